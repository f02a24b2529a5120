"""Random scenes, rigs and motions for laws: every bed that is built, through one strategy."""

from dataclasses import replace

from hypothesis import strategies as st

from rig.catalog.entries import Rig
from rig.drive.waveform import Waveform
from rig.protocol.feasibility import conflicts
from rig.protocol.spec import (
    HORIZONTAL_ONLY_BEDS,
    Acquire,
    Cavity,
    Dashpot,
    Drive,
    Grains,
    Layers,
    Scene,
    SingleMass,
)

LOSSES = ("noise", "air", "mount")
"""Loss channels that know nothing of the air's own density and viscosity."""

fractions = st.sampled_from((0.0, 1.0)) | st.floats(0.02, 0.98)
cavities = st.builds(
    Cavity, st.floats(0.05, 0.3), st.floats(0.05, 0.3), st.floats(0.05, 0.3), st.floats(1e-3, 0.02)
)
"""Boxes of 5 to 30 cm: a few dozen layers at most with the grains below."""

grains = st.builds(
    Grains, st.just("stainless"), st.floats(5e-3, 2e-2), fractions, st.floats(500.0, 2e4)
)
layers = st.builds(
    Layers, st.just(0.0) | st.floats(1e-3, 20.0), fractions, st.integers(1, 4), st.booleans()
)
gaps = st.none() | st.sampled_from(("none", 0.0)) | st.floats(1e-4, 0.3)
single_masses = st.builds(
    SingleMass,
    st.floats(0.0, 0.95),
    gaps,
    st.just(0.0) | st.floats(0.01, 1.0),
    st.just(0.0) | st.floats(1e-4, 0.3),
    st.just(0.0) | st.floats(-1.0, -1e-3) | st.floats(1e-3, 1.0),
)
losses = st.lists(st.sampled_from(LOSSES), unique=True).map(tuple)
supports = st.sampled_from(("none", "cords", "guide"))
drives = st.builds(Drive, frequency=st.floats(5.0, 60.0), acceleration=st.floats(0.05, 40.0))


def scenes(bed: str) -> st.SearchStrategy[Scene]:
    """Scenes with a bed, on every axis where it is built, each of which a protocol could ask for."""
    axes = (
        ("horizontal",)
        if bed in HORIZONTAL_ONLY_BEDS
        else ("horizontal", "vertical", "zero_gravity")
    )
    made = st.builds(
        Scene,
        cavities,
        st.sampled_from(axes),
        grains,
        st.just(bed),
        losses,
        supports,
        layers,
        single_masses,
        st.builds(Dashpot, st.just(0.0) | st.floats(1e-3, 1e3)),
    )
    return made.map(_sensible).filter(lambda scene: not any(conflicts(scene, Drive(), Acquire())))


def _sensible(scene: Scene) -> Scene:
    """The scene without what does not go with its axis."""
    single_mass = scene.single_mass
    if isinstance(single_mass.gap, float):
        room = scene.cavity.length if scene.axis == "horizontal" else scene.cavity.height
        gap = min(single_mass.gap, 0.9 * room)
        single_mass = replace(single_mass, gap=gap, start=min(single_mass.start, gap))
    if scene.axis == "horizontal":
        return replace(scene, single_mass=single_mass)
    support = "cords" if scene.support == "guide" else scene.support
    return replace(scene, single_mass=replace(single_mass, friction=0.0), support=support)


@st.composite
def motions(draw: st.DrawFn, drive: Drive, exact: bool = False) -> Waveform:
    """The motion of a drive: an exact sine, or with a second and a third harmonic of up to 10 %."""
    if exact:
        return Waveform(drive.frequency, drive.acceleration)
    wave = [draw(st.just(0.0) | st.floats(1e-6, 0.1) | st.floats(-0.1, -1e-6)) for _ in range(4)]
    return Waveform(
        drive.frequency, drive.acceleration, (1.0, wave[0], wave[1]), (0.0, wave[2], wave[3])
    )


def rigs(rig: Rig, bed: str) -> st.SearchStrategy[Rig]:
    """The rig with other friction and restitution; few of these, since a file's collision is found
    once for each. Bed `column` is known for the friction of its table alone.
    """
    friction = st.just(0.0) | st.floats(1e-6, 1.0)
    return st.builds(
        replace, st.just(rig),
        grain_friction=st.just(rig.grain_friction) if bed == "column" else friction,
        restitution_grains=st.sampled_from((0.5, 0.9, 0.99)),
        restitution_wall=st.sampled_from((0.0, 0.75, 1.0)),
    )  # fmt: skip
