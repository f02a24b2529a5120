"""Scenes and a rig for the laws; every number is a catalog default unless a test says otherwise."""

import pytest

from rig.catalog.entries import Rig
from rig.catalog.rig_file import load_rig
from rig.protocol.spec import Grains, Scene


@pytest.fixture(scope="session")
def rig() -> Rig:
    return load_rig("paper")


@pytest.fixture
def steel() -> Scene:
    return Scene(grains=Grains(density=7900.0))
