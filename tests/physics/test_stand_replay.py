"""A stand that repeats itself hands out its chunks again: nothing in the record may tell."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from rig.beds.janssen_stack import nominal
from rig.catalog.entries import Rig
from rig.drive.waveform import Waveform
from rig.protocol.spec import Grains, Layers, Scene
from rig.stand.prescribed import Replay, Stand

Array = NDArray[np.float64]

PER_CYCLE = 512
CYCLES = 60

EMPTY = Scene(bed="empty", grains=Grains(density=7900.0))
FINE = Scene(grains=Grains(density=7900.0, diameter=1e-3, fill=0.2), layers=Layers(rows=4))
SCENES = {
    "empty": (EMPTY, 5.0),
    "locked on cords": (replace(EMPTY, bed="locked", losses=("mount",), support="cords"), 5.0),
    "dashpot": (replace(EMPTY, bed="dashpot"), 5.0),
    "rows of period 1": (FINE, 5.0),
    "rows of periods 1 and 3": (
        Scene(grains=Grains(density=7900.0, fill=0.2), layers=Layers(rows=4)),
        4.0,
    ),
    "rows without a common period": (Scene(grains=Grains(density=7900.0)), 2.0),
}


def record(
    scene: Scene, rig: Rig, acceleration: float, per_cycle: float
) -> tuple[Array, Array, int]:
    """Means and ledger of a run, and how many chunks were replayed."""
    stand = Stand(scene, rig, Waveform(20.0, acceleration), nominal(scene, rig), 20.0 * per_cycle)
    means = stand.read(int(CYCLES * per_cycle) - 1)
    return means, stand.drain_ledger(), stand._replay._turn


@pytest.mark.parametrize("name", SCENES)
def test_replayed_chunks_are_what_a_simulation_gives(
    name: str, rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, acceleration = SCENES[name]
    means, ledger, replayed = record(scene, rig, acceleration, PER_CYCLE)
    monkeypatch.setattr(Replay, "note", lambda *_: None)
    simulated, account, none = record(scene, rig, acceleration, PER_CYCLE)
    assert none == 0
    assert (replayed > 0) == (name != "rows without a common period")
    assert np.array_equal(means, simulated)
    assert np.array_equal(ledger, account)


def test_a_grid_that_drifts_through_the_cycle_is_never_replayed(rig: Rig) -> None:
    """512.3 edges per cycle: steady rows, and yet no chunk is like another."""
    assert record(FINE, rig, 5.0, 512.3)[2] == 0
