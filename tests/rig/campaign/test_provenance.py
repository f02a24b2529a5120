"""Where a session says that it comes from."""

import pytest

from rig.campaign.provenance import cpu, provenance


def test_provenance_names_the_processor_and_the_options_of_its_instructions(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("NPY_DISABLE_CPU_FEATURES", "AVX512F")
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    found = provenance("text", 7, 1.0)["cpu"]
    assert found == cpu()
    assert found["name"]
    assert found["features"].split() == sorted(found["features"].split())
    assert (found["NPY_DISABLE_CPU_FEATURES"], found["OMP_NUM_THREADS"]) == ("AVX512F", "1")
