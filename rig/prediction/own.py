"""The bed's own prediction: W_T event-resolved or in closed form, by the mechanism of the scene's
bed, with its upper bound.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rig.beds.column import rows_of
from rig.beds.janssen_stack import Filling, Stack, bed_mass, layer_count, nominal
from rig.beds.layers import cannot_follow
from rig.beds.single_mass import single_mass, too_many_events
from rig.catalog.entries import Rig
from rig.kernels.single_mass.many_cycles import AVERAGE, SETTLE
from rig.protocol.spec import BEDS_OF_ROWS, Condition, Scene
from rig.stand.box import box_mass
from rig.theory.single_mass import SingleMassTotal, single_mass_total
from rig.theory.total import (
    AVERAGED_CYCLES,
    ModelEnergy,
    TooManyEvents,
    layers_total,
    plastic_bound,
    slider_bound,
)

LEVELS = (0.97, 0.98, 0.99, 1.0, 1.01, 1.02, 1.03)
"""Levels, relative to the set acceleration, at which W_T is computed for interpolation to the
measured acceleration.
"""

READ = 1.0 / math.sqrt(2.0)
"""Standard uncertainty of an interpolated W_T, divided by the largest error of interpolating one
level from its neighbours.

Where rows lock to the drive, W_T is rough as a function of the level, down to steps of 0.1 %: no
table is fine enough. With a roughness of standard deviation s, W_T interpolated half way differs by
sqrt(3/2) s from the value there, and by sqrt(5/3) s = 1.29 s on average over the interval; the mean
of the largest of five errors at the tabulated levels is 1.84 s.
"""

SINGLE_MASS_LEVELS = tuple(0.97 + 0.002 * n for n in range(31))
"""The levels for a single mass: closer, because it may be on another orbit at a slightly different
level.
"""

SINGLE_MASS_AVERAGE = (256, 1024)
"""Cycles of settling and averaging of a single-mass orbit without a period, at levels other than
the set one.
"""

SINGLE_MASS_REACH = 5
"""Levels to either side of the set one within which the measured one is expected: 1 %."""

SINGLE_MASS_ERROR = 1e-9
"""Relative error of W_T of a single mass on an orbit with a period
(tests/physics/test_single_mass_orbits.py).
"""

NUMERICAL_ERROR = 1e-3
"""Relative standard uncertainty of W_T due to numerics: averaging of rows without a period
(tests/physics).
"""

NOTHING = ModelEnergy(0.0, 0.0, 1, 1.0)


@dataclass(frozen=True)
class OwnPrediction:
    """Predicted energy per cycle for one condition and its parts, J (masses in kg).

    Relative standard uncertainties of W_T: u_rel of the numerics; and, if it was computed at
    several levels, u_levels of the interpolation between them, and u_settling, the difference
    between the steady state and the mean of the recorded cycles, for a bed that starts at rest.
    """

    bed_mass: float
    box_mass: float
    layers: int
    carried: bool
    W_f: float
    W_c: float
    W_T: float
    bound: float
    period: int
    periodic_share: float
    u_rel: float = NUMERICAL_ERROR
    u_levels: float = 0.0
    u_settling: float = 0.0


def total_of(
    scene: Scene, rig: Rig, filling: Filling, acceleration: float, frequency: float
) -> ModelEnergy:
    """Return W_T of one filling at one acceleration, by the mechanism of the scene's bed."""
    if scene.bed == "single_mass":
        return single_mass_variant(scene, rig, filling, acceleration, frequency).total
    return layers_variant(scene, rows_of(scene, rig, filling), acceleration, frequency)


def single_mass_variant(
    scene: Scene,
    rig: Rig,
    filling: Filling,
    acceleration: float,
    frequency: float,
    settle: int = SETTLE,
    average: int = AVERAGE,
    window: tuple[int, int] | None = None,
) -> SingleMassTotal:
    """Return the energy of the single mass of one filling at one acceleration.

    Raises InputError if it bounces too often to be followed.
    """
    bed = single_mass(scene, rig, filling)
    try:
        return single_mass_total(bed, acceleration, frequency, settle, average, window)
    except TooManyEvents as error:
        raise too_many_events(bed) from error


def layers_variant(
    scene: Scene, bed: Stack, acceleration: float, frequency: float, cycles: int = AVERAGED_CYCLES,
    window: tuple[int, int] | None = None,
) -> ModelEnergy:  # fmt: skip
    """Return the event-resolved energy of the rows of bed `layers` or `column` at one acceleration;
    zero for beds that do not slide by design.

    window : (first cycle, one past the last) of an additional mean

    Raises InputError if a row cannot be followed.
    """
    if scene.bed not in BEDS_OF_ROWS:
        return NOTHING
    try:
        return layers_total(
            bed.threshold,
            bed.clearance,
            bed.row_mass,
            bed.restitution,
            acceleration,
            frequency,
            cycles,
            window,
        )
    except TooManyEvents as error:
        raise cannot_follow(bed, str(error)) from error


def predict_own(condition: Condition, rig: Rig, cycles: int = AVERAGED_CYCLES) -> OwnPrediction:
    """Return the bed's own prediction for one condition on an exact sine at the set acceleration."""
    scene, drive = condition.scene, condition.drive
    if scene.bed == "single_mass":
        found = single_mass_variant(
            scene, rig, nominal(scene, rig), drive.acceleration, drive.frequency
        )
        return _single_mass_prediction(condition, rig, found)
    bed = rows_of(scene, rig, nominal(scene, rig))
    return _prediction(
        condition, rig, bed, layers_variant(scene, bed, drive.acceleration, drive.frequency, cycles)
    )


def predict_own_about(
    condition: Condition, rig: Rig, cycles: int = AVERAGED_CYCLES
) -> tuple[OwnPrediction, list[float], list[ModelEnergy]]:
    """Return the result of `predict_own`, levels about the set acceleration (m/s^2), and the energy
    at each of them.
    """
    scene, drive = condition.scene, condition.drive
    if scene.bed == "single_mass":
        return _single_mass_about(condition, rig)
    bed = rows_of(scene, rig, nominal(scene, rig))
    levels = levels_about(drive.acceleration)
    totals = [
        layers_variant(scene, bed, level, drive.frequency, cycles, _window(condition))
        for level in levels
    ]
    point = _prediction(condition, rig, bed, totals[LEVELS.index(1.0)])
    return _with_uncertainty(point, levels, totals), levels, totals


def layers_energies(
    condition: Condition, rig: Rig, levels: Sequence[float], cycles: int
) -> list[ModelEnergy]:
    """Return the energy of the layers variant at each level, whatever the bed, in its steady state.
    Raises InputError if a row cannot be followed.
    """
    scene = replace(condition.scene, bed="layers")
    bed = rows_of(scene, rig, nominal(scene, rig))
    frequency = condition.drive.frequency
    return [layers_variant(scene, bed, level, frequency, cycles) for level in levels]


def levels_about(acceleration: float) -> list[float]:
    """Return the levels about a set acceleration at which W_T is tabulated, m/s^2."""
    return [acceleration * level for level in LEVELS]


def _window(condition: Condition) -> tuple[int, int]:
    """Return the recorded cycles of a condition: (first, one past the last)."""
    acquire = condition.acquire
    return acquire.settle, acquire.settle + acquire.record


def _with_uncertainty(
    point: OwnPrediction, levels: Sequence[float], totals: Sequence[ModelEnergy]
) -> OwnPrediction:
    """Return a prediction with u_levels and u_settling from levels (m/s^2) about the set one.

    u_settling is the root mean square over all levels, because at a single one the few rows may
    settle at once.
    """
    if point.W_T <= 0.0:
        return point
    apart = []
    for total in totals:
        if total.window is not None and total.total > 0.0:
            apart.append(total.window / total.total - 1.0)
    return replace(
        point,
        u_levels=READ * misread(levels, [total.total for total in totals]) / point.W_T,
        u_settling=math.sqrt(math.fsum(value**2 for value in apart) / len(apart)),
    )


def misread(levels: Sequence[float], W: Sequence[float]) -> float:
    """Return the largest error, J, of W at the inner levels when interpolated from its neighbours
    as `analysis.session.prediction` does.

    A power law between them, a straight line if W is 0 at one.
    """
    errors = [0.0]
    for n in range(1, len(levels) - 1):
        (a0, a, a1), (W0, found, W1) = levels[n - 1 : n + 2], W[n - 1 : n + 2]
        if W0 > 0.0 and W1 > 0.0:
            read = W0 * (W1 / W0) ** (math.log(a / a0) / math.log(a1 / a0))
        else:
            read = W0 + (W1 - W0) * (a - a0) / (a1 - a0)
        errors.append(abs(read - found))
    return max(errors)


def _single_mass_about(
    condition: Condition, rig: Rig
) -> tuple[OwnPrediction, list[float], list[ModelEnergy]]:
    """Return what `predict_own_about` returns, of a single mass.

    Where its orbit jumps between levels, the uncertainty of W_T at the measured level is the error
    of interpolating each level from its neighbours: half of a jump at the jump.
    """
    drive, filling, window = condition.drive, nominal(condition.scene, rig), _window(condition)

    def tier(level: float, cycles: tuple[int, int]) -> SingleMassTotal:
        return single_mass_variant(
            condition.scene, rig, filling, level, drive.frequency, *cycles, window
        )

    levels = [drive.acceleration * level for level in SINGLE_MASS_LEVELS]
    set_level = len(levels) // 2
    found = [tier(level, SINGLE_MASS_AVERAGE) for level in levels]
    found[set_level] = tier(drive.acceleration, (SETTLE, AVERAGE))
    totals, point = (
        [one.total for one in found],
        _single_mass_prediction(condition, rig, found[set_level]),
    )
    near = slice(set_level - SINGLE_MASS_REACH - 1, set_level + SINGLE_MASS_REACH + 2)
    return _with_uncertainty(point, levels[near], totals[near]), levels, totals


def _single_mass_prediction(
    condition: Condition, rig: Rig, found: SingleMassTotal
) -> OwnPrediction:
    scene = condition.scene
    mass = bed_mass(scene, rig.packing_shaken)
    return OwnPrediction(
        bed_mass=mass,
        box_mass=box_mass(scene.cavity, rig.wall_density),
        layers=layer_count(scene),
        carried=mass > 0.0 and not found.moves,
        W_f=found.total.friction,
        W_c=found.total.collision,
        W_T=found.total.total,
        bound=found.bound,
        period=found.total.period,
        periodic_share=found.total.periodic_share,
        u_rel=math.hypot(SINGLE_MASS_ERROR, found.error),
    )


def _prediction(condition: Condition, rig: Rig, bed: Stack, total: ModelEnergy) -> OwnPrediction:
    scene, drive = condition.scene, condition.drive
    velocity = drive.acceleration / (2.0 * np.pi * drive.frequency)
    has_grains = scene.bed in (*BEDS_OF_ROWS, "locked")
    mass = bed_mass(scene, rig.packing_shaken) if has_grains else 0.0
    return OwnPrediction(
        bed_mass=mass,
        box_mass=box_mass(scene.cavity, rig.wall_density),
        layers=layer_count(scene) if has_grains else 0,
        carried=mass > 0.0 and total.total == 0.0,
        W_f=total.friction,
        W_c=total.collision,
        W_T=total.total,
        bound=_bound(scene, bed, mass, velocity),
        period=total.period,
        periodic_share=total.periodic_share,
    )


def _bound(scene: Scene, bed: Stack, mass: float, velocity: float) -> float:
    """Return the upper bound of the energy that a bed dissipates per cycle, J; 0 for beds that do
    not slide.
    """
    if scene.bed == "column":
        return slider_bound(mass, velocity)
    return plastic_bound(mass, velocity, bed.restitution) if scene.bed == "layers" else 0.0
