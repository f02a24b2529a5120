"""W_T of a condition: the prediction that its protocol names, and all others that apply."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from rig.beds.janssen_stack import bed_mass, layer_count
from rig.catalog.entries import Rig
from rig.drive.waveform import Waveform
from rig.errors import InputError
from rig.prediction.own import (
    NUMERICAL_ERROR,
    READ,
    OwnPrediction,
    layers_energies,
    levels_about,
    misread,
    predict_own,
    predict_own_about,
)
from rig.prediction.variants import VARIANTS, Variant, event_resolved, variants
from rig.protocol.spec import LOCKING_LEVEL, RIGID_BEDS, Condition, Scene, SingleMass
from rig.stand.box import box_mass
from rig.theory.single_mass import thrown_height
from rig.theory.total import AVERAGED_CYCLES, ModelEnergy, plastic_bound

SINGLE_MASS_FOR_GRAINS = 0.15
"""Relative standard uncertainty of the single mass as a prediction of vertical grains up to
`LOCKING_LEVEL` (assumed; 0.89 times resolved grains in the one case at 2 g and a fill of 0.85).
"""


@dataclass(frozen=True)
class Prediction:
    """Predicted energy per cycle for one condition and its parts, J (masses in kg).

    prediction : name of the one that W_T is of: layers, column, as_printed, own or band
    W_f, W_c : its parts, None if it has none
    W_T : None for a band, from W_T_low to W_T_high, and where the named prediction is not stated
    W_T_as_printed, W_T_layers, W_T_column : the others, with expanded uncertainties (k = 2) of
        numerics and formula, None where they are not stated
    reasons : why, by the key of what is not stated
    bound : upper bound; period, periodic_share : of the bed's own prediction, None if W_T is
        another
    W_own : of the bed's own prediction, None without one
    shares_mechanism : whether W_T comes from the mechanism of the bed itself, so that a comparison
        tests the measurement and not the model

    Relative standard uncertainties of W_T: u_rel of the numerics; if it was computed at several
    levels, u_levels of the interpolation between them, and u_settling, the difference between the
    steady state and the mean of the recorded cycles, for a bed that starts at rest; u_stated of the
    formula itself.
    """

    bed_mass: float
    box_mass: float
    layers: int
    carried: bool
    prediction: str
    W_f: float | None
    W_c: float | None
    W_T: float | None
    W_T_low: float | None
    W_T_high: float | None
    W_T_as_printed: float | None
    U_W_T_as_printed: float | None
    W_T_layers: float | None
    U_W_T_layers: float | None
    W_T_column: float | None
    U_W_T_column: float | None
    reasons: Mapping[str, str]
    bound: float
    period: int | None
    periodic_share: float | None
    W_own: float | None
    shares_mechanism: bool
    u_rel: float = 0.0
    u_levels: float = 0.0
    u_settling: float = 0.0
    u_stated: float = 0.0


def predict(condition: Condition, rig: Rig, cycles: int = AVERAGED_CYCLES) -> Prediction:
    """Return W_T for one condition on an exact sine at the set acceleration, by every prediction
    that applies, and the bound.
    """
    with_own = _with_own(condition, rig)
    own = None if with_own is None else predict_own(with_own, rig, cycles)
    totals = []
    if own is not None:
        totals = [ModelEnergy(own.W_f, own.W_c, own.period, own.periodic_share)]
    return _predicted(condition, rig, own, [condition.drive.acceleration], totals, cycles)[0]


def predict_about(
    condition: Condition, rig: Rig, cycles: int = AVERAGED_CYCLES
) -> tuple[Prediction, dict[str, Any]]:
    """Return the result of `predict`, and a table about the set acceleration.

    The table is interpolated at the measured acceleration: plain numbers that another model's
    numbers can replace. Lists beside `acceleration` (m/s^2): W_T, W_f, W_c, or W_T_low and W_T_high
    of a band (J); `variants` by name with their own W_T.
    """
    with_own = _with_own(condition, rig)
    if with_own is None:
        levels = levels_about(condition.drive.acceleration)
        return _predicted(condition, rig, None, levels, [], cycles)
    return _predicted(condition, rig, *predict_own_about(with_own, rig, cycles), cycles)


def _with_own(condition: Condition, rig: Rig) -> Condition | None:
    """Return the condition whose own prediction is the condition's; None without one.

    Resolved grains have none, but on a vertical axis they fly as one mass up to `LOCKING_LEVEL`.
    """
    scene, level = condition.scene, condition.drive.acceleration
    if scene.bed != "grains":
        return condition
    if scene.axis != "vertical" or level > LOCKING_LEVEL * rig.gravity:
        return None
    return replace(condition, scene=replace(scene, bed="single_mass", single_mass=SingleMass()))


def _predicted(
    condition: Condition,
    rig: Rig,
    own: OwnPrediction | None,
    levels: Sequence[float],
    totals: Sequence[ModelEnergy],
    cycles: int,
) -> tuple[Prediction, dict[str, Any]]:
    """Return the prediction and its table from the bed's own at the levels; empty without one."""
    scene = condition.scene
    if own is None:
        by_bed = Variant(None, why=f"bed {scene.bed} has no prediction of its own here")
    else:
        stated = SINGLE_MASS_FOR_GRAINS if scene.bed == "grains" else 0.0
        by_bed = event_resolved(
            totals,
            u_rel=own.u_rel,
            u_levels=own.u_levels,
            u_settling=own.u_settling,
            u_stated=stated,
        )

    def layers_of_any_bed() -> Variant:
        # Bed `layers` has just computed them as its own.
        return by_bed if scene.bed == "layers" else _layers(condition, rig, levels, cycles)

    known = variants(condition, rig, levels, layers_of_any_bed)
    known["own"] = by_bed
    if scene.bed == "layers":
        known["layers"] = by_bed
    bounds = [_bound(condition, rig, own, level) for level in levels]
    known["band"] = Variant(None, why="a band, no number: see W_T_low and W_T_high")
    name = _headline(condition, known)
    chosen, middle = known[name], len(levels) // 2
    shared = scene.bed != "grains" and name in ("own", scene.bed if scene.bed == "layers" else "")
    printed, layers, column = (_with_U(known[each], middle) for each in VARIANTS)
    reasons = {f"W_T_{each}": known[each].why for each in VARIANTS if known[each].why}
    if chosen.why:
        reasons["W_T"] = chosen.why
    mass = _grain_mass(scene, rig) if own is None else own.bed_mass
    point = Prediction(
        bed_mass=mass,
        box_mass=box_mass(scene.cavity, rig.wall_density),
        layers=layer_count(scene) if own is None else own.layers,
        carried=own is not None and own.carried and scene.bed != "grains",
        prediction=name,
        W_f=_at(chosen.W_f, middle),
        W_c=_at(chosen.W_c, middle),
        W_T=_at(chosen.W_T, middle),
        W_T_low=0.0 if name == "band" else None,
        W_T_high=bounds[middle] if name == "band" else None,
        W_T_as_printed=printed[0],
        U_W_T_as_printed=printed[1],
        W_T_layers=layers[0],
        U_W_T_layers=layers[1],
        W_T_column=column[0],
        U_W_T_column=column[1],
        reasons=reasons,
        bound=bounds[middle],
        period=own.period if own is not None and shared else None,
        periodic_share=own.periodic_share if own is not None and shared else None,
        W_own=own.W_T if own is not None and scene.bed != "grains" else None,
        shares_mechanism=shared,
        u_rel=chosen.u_rel,
        u_levels=chosen.u_levels,
        u_settling=chosen.u_settling,
        u_stated=chosen.u_stated,
    )
    table: dict[str, Any] = {"acceleration": list(levels)}
    table["W_T"] = None if chosen.W_T is None else list(chosen.W_T)
    for key, values in (("W_f", chosen.W_f), ("W_c", chosen.W_c)):
        if values is not None:
            table[key] = list(values)
    if name == "band":
        table |= {"W_T_low": [0.0] * len(levels), "W_T_high": bounds}
    table["variants"] = {each: _plain(known[each]) for each in VARIANTS}
    return point, table


def _layers(condition: Condition, rig: Rig, levels: Sequence[float], cycles: int) -> Variant:
    """Return the layers variant of a condition whatever its bed."""
    try:
        totals = layers_energies(condition, rig, levels, cycles)
    except InputError as error:
        return Variant(None, why=error.mistakes[0].found)
    middle = totals[len(totals) // 2].total
    apart = READ * misread(levels, [total.total for total in totals])
    return event_resolved(totals, NUMERICAL_ERROR, apart / middle if middle > 0.0 else 0.0)


def _headline(condition: Condition, known: Mapping[str, Variant]) -> str:
    """Return the name of the prediction that W_T is of: the protocol's, or the default of the bed."""
    bed = condition.scene.bed
    if bed in RIGID_BEDS:
        return "own"
    if condition.prediction is not None:
        return condition.prediction
    if bed == "layers":
        return "layers"
    return next((name for name in ("own", "column") if known[name].W_T is not None), "band")


def _with_U(variant: Variant, place: int) -> tuple[float | None, float | None]:
    """Return a variant's energy at one level and its expanded uncertainty (k = 2), J."""
    W_T = _at(variant.W_T, place)
    u = math.hypot(variant.u_rel, variant.u_levels, variant.u_settling, variant.u_stated)
    return W_T, None if W_T is None else 2.0 * u * W_T


def _at(values: Sequence[float] | None, place: int) -> float | None:
    return None if values is None else values[place]


def _plain(variant: Variant) -> dict[str, Any]:
    """Return a variant for the session, without its parts and what is zero or empty."""
    found = {key: value for key, value in asdict(variant).items() if value}
    found["W_T"] = None if variant.W_T is None else list(variant.W_T)
    return {key: value for key, value in found.items() if key not in ("W_f", "W_c")}


def _grain_mass(scene: Scene, rig: Rig) -> float:
    return bed_mass(scene, rig.packing_shaken)


def _bound(condition: Condition, rig: Rig, own: OwnPrediction | None, level: float) -> float:
    """Return the upper bound of the energy per cycle at a level (m/s^2), J.

    Grains: m g V/f on a vertical axis where no grain reaches the lid, because the mean contact
    force is m g and never negative. A lid pushes down as well, and so do end walls: 4 m V^2, two
    plastic hits of the whole bed per cycle.
    """
    scene, drive = condition.scene, condition.drive
    if own is not None and scene.bed != "grains":
        return own.bound * (level / drive.acceleration) ** 2
    mass, velocity = _grain_mass(scene, rig), Waveform(drive.frequency, level).velocity_unit
    if scene.axis == "vertical" and rig.gravity > 0.0:
        room = (1.0 - scene.grains.fill) * scene.cavity.height
        if room > thrown_height(velocity, drive.frequency, rig.gravity):
            return mass * rig.gravity * velocity / drive.frequency
    return plastic_bound(mass, velocity, 0.0)
