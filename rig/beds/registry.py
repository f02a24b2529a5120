"""The beds by the names of the protocol."""

from collections.abc import Callable

from rig.beds.bed import Bed
from rig.beds.janssen_stack import Filling, bed_mass, stack
from rig.beds.layers import Layers
from rig.beds.rigid import Dashpot, Locked
from rig.beds.single_mass import SlugBed, slug
from rig.catalog.entries import Rig
from rig.drive.waveform import Sampling
from rig.protocol.spec import Scene

BEDS: dict[str, Callable[[Scene, Rig, Filling, Sampling], Bed]] = {
    "empty": lambda _scene, _rig, _filling, sampling: Locked(0.0, sampling),
    "loop_back": lambda _scene, _rig, _filling, sampling: Locked(0.0, sampling),
    "locked": lambda scene, _rig, filling, sampling: Locked(bed_mass(scene, filling.packing), sampling),
    "dashpot": lambda scene, _rig, _filling, sampling: Dashpot(scene.dashpot.c, sampling),
    "slug": lambda scene, rig, filling, sampling: SlugBed(slug(scene, rig, filling), sampling),
    "layers": lambda scene, rig, filling, sampling: Layers(stack(scene, rig, filling), sampling),
}
"""Bed by name: (scene, rig, filling, sampling) -> a bed at the start of the motion."""
