"""Maps the bed names of a protocol to the bed models."""

from collections.abc import Callable

from rig.beds.bed import Bed
from rig.beds.column import rows_of
from rig.beds.janssen_stack import Filling, bed_mass
from rig.beds.layers import LayersBed
from rig.beds.rigid import DashpotBed, LockedBed
from rig.beds.single_mass import SingleMassBed, single_mass
from rig.catalog.entries import Rig
from rig.drive.waveform import Sampling
from rig.protocol.spec import Scene


def _rows(scene: Scene, rig: Rig, filling: Filling, sampling: Sampling) -> Bed:
    return LayersBed(rows_of(scene, rig, filling), sampling)


BEDS: dict[str, Callable[[Scene, Rig, Filling, Sampling], Bed]] = {
    "empty": lambda _scene, _rig, _filling, sampling: LockedBed(0.0, sampling),
    "loop_back": lambda _scene, _rig, _filling, sampling: LockedBed(0.0, sampling),
    "locked": lambda scene, _rig, filling, sampling: LockedBed(
        bed_mass(scene, filling.packing), sampling
    ),
    "dashpot": lambda scene, _rig, _filling, sampling: DashpotBed(scene.dashpot.c, sampling),
    "single_mass": lambda scene, rig, filling, sampling: SingleMassBed(
        single_mass(scene, rig, filling), sampling
    ),
    "layers": _rows,
    "column": _rows,
}
"""Maps the name of a bed to its factory: (scene, rig, filling, sampling) -> bed at the start of the
motion.
"""
