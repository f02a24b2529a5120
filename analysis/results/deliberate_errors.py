"""Deliberate errors: the wrong readings, and for each a rule that predicts the error of the result.

R = (pi/w^2) M_eff a^2 is the error of W per radian of phase error; eta = W/R the loss factor.
Relative errors of W:

    pole, skew, clock  dphi/eta, dphi the lead of the acceleration (its mean, where it slides)
    corners            dphi/eta, less the fraction by which the AC coupling reduces both amplitudes
    cycles             sin(4 pi n)/(4 pi n) - sin^2(2 pi n)/(2 pi n eta), n cycles from the start of
                       a drive cycle
    coil               pi c a^2/w^3 of the armature's flexure, over W
    offset             2 e/eta, e the offset over the level, integrated from rest without removing a
                       mean
    friction           4 mu M g X, over W
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.energy.energy_and_phasors import Energy
from analysis.results.condition import Result
from analysis.results.deliberate_error_rows import DeliberateErrorReport, DeliberateErrorRow
from analysis.session.ledger_columns import DISSIPATED
from analysis.session.record import ChannelFacts
from analysis.session.setting import SessionDeliberateError
from analysis.signals.correction import pole_phase
from analysis.signals.integration import integral

__all__ = ["deliberate", "misread"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Words:
    """A deliberate error in words: the action with `{value}` filled in, the rule, and the sign by
    which to notice it.
    """

    what: str
    rule: str
    notice: str


ANGLE = "error = dphi/eta"
NOTHING = 1e-9
"""Loss factor of round-off: below it no energy was dissipated that an error could refer to."""
WORDS: Mapping[str, Words] = {
    "pole": Words(
        "the accelerometer's true time constant is {value:g} times the certified one, by which the record is corrected",
        f"{ANGLE}, dphi = atan(1/(w tau)) - atan(1/(w tau_certified))",
        "the locked bed's angle, larger at lower frequencies",
    ),
    "corners": Words(
        "both channels are AC coupled at 0.5 Hz and nobody wrote it down; the acceleration's corner lies {percent:g} % "
        "above the force's",
        f"{ANGLE}, dphi = atan(f_acceleration/f) - atan(f_force/f), less (f_force^2 + f_acceleration^2)/(2 f^2) for "
        "the amplitude that the coupling takes",
        "the locked bed's angle, larger at lower frequencies",
    ),
    "cycles": Words(
        "W is read over {value:g} cycles instead of whole ones",
        "error = sin(4 pi n)/(4 pi n) - sin^2(2 pi n)/(2 pi n eta)",
        "W_exp against W_phasor, which stays right: on whole cycles the two are equal; the locked bed's angle",
    ),
    "skew": Words(
        "the acceleration channel comes {value:g} sample{plural} late",
        f"{ANGLE}, dphi = -w delay",
        "the locked bed's angle, growing with the frequency",
    ),
    "clock": Words(
        "the acceleration channel runs on a clock of its own, {value:g} ppm fast",
        f"{ANGLE}, dphi = -w (clock error) (time from the start to the middle of the record)",
        "W, which slides from cycle to cycle; the locked bed's angle, growing with the length of the record",
    ),
    "coil": Words(
        "the force is taken from the coil's current, with the armature and its flexure in it (c = {value:.3g} N s/m)",
        "error = (pi c a^2/w^3)/W",
        "the empty box's apparent mass (off by m - k/w^2, the rigid mass reference) and its W",
    ),
    "offset": Words(
        "the acceleration has a DC offset of {percent:g} % of its level, and is integrated without taking off any mean",
        "error = 2 offset/eta",
        "the velocity, which runs away; W_exp against W_phasor, which stays right; the locked bed's angle",
    ),
    "friction": Words(
        "the box runs on a guide, and what its friction (mu = {value:g}) takes is read as the bed's",
        "error = 4 mu M g X/W",
        "no angle: the locked bed's W, which grows as a and with the mass carried, not as a^2",
    ),
}


def misread(
    energy: Energy, error: SessionDeliberateError, force: Array, acceleration: Array
) -> Energy:
    """Return a window's energies with W read wrongly, where the deliberate error is one of the
    reading.

    Otherwise they are unchanged. force (N), acceleration (m/s^2): the window's samples as recorded,
    a whole number in each of `energy.cycles` cycles.
    """
    points = force.size // energy.cycles
    step = 1 / (energy.frequency * points)
    if error.kind == "cycles":
        return replace(
            energy, W=_broken_cycles(force, acceleration, step, points, float(error.value))
        )
    if error.kind == "offset":
        velocity = (np.cumsum(acceleration) - 0.5 * acceleration) * step
        return replace(energy, W=float(np.einsum("i,i->", force, velocity)) * step / energy.cycles)
    return energy


def _broken_cycles(
    force: Array, acceleration: Array, step: float, points: int, cycles: float
) -> float:
    """Return W, J per cycle, from the integral of F v dt over the first `cycles` cycles; means are
    those of the window.
    """
    velocity = integral(acceleration - acceleration.mean(), step)
    power = (force - force.mean()) * (velocity - velocity.mean())
    last = min(round(cycles * points), power.size - 1)
    return float(power[: last + 1].sum() - 0.5 * (power[0] + power[last])) * step / cycles


def deliberate(
    results: Sequence[Result], channels: Mapping[str, ChannelFacts]
) -> DeliberateErrorReport | None:
    """Return the deliberate error of a session and its effect on each condition; None where there
    is none.
    """
    made = [
        (result, result.setting.deliberate_error)
        for result in results
        if result.setting.deliberate_error is not None
    ]
    if not made:
        return None
    kind, value = made[0][1].kind, float(made[0][1].value)
    words = WORDS[kind]
    return DeliberateErrorReport(
        kind=kind,
        parameter=value,
        what=words.what.format(value=value, percent=100 * value, plural="s" * (value > 1)),
        rule=words.rule,
        notice=words.notice,
        conditions=tuple(_row(result, error, channels) for result, error in made),
    )


def _row(
    result: Result, error: SessionDeliberateError, channels: Mapping[str, ChannelFacts]
) -> DeliberateErrorRow:
    """Return the effect on one condition."""
    found, name = result.W_exp.value, result.setting.id
    true = _true(result, error.kind)
    if true is None or not true > NOTHING * abs(result.mean("reactive")):
        return DeliberateErrorRow(name, found, true, None, None, None, None)
    eta = true / result.mean("reactive")
    relative, predicted = found / true - 1, _predicted(result, error, channels, true, eta)
    return DeliberateErrorRow(
        name, found, true, eta, relative, predicted, relative / predicted if predicted else None
    )


def _true(result: Result, kind: str) -> float | None:
    """Return the true energy, J per cycle, from the ledgers of the condition's runs; None without
    them.
    """
    ledgers = [run.ledger for run in result.runs if run.ledger is not None]
    if len(ledgers) < len(result.runs):
        return None
    names = [name for name in DISSIPATED if kind != "friction" or name != "W_mount"]
    return math.fsum(ledger.get(name, 0.0) for ledger in ledgers for name in names) / len(ledgers)


def _predicted(
    result: Result,
    error: SessionDeliberateError,
    channels: Mapping[str, ChannelFacts],
    true: float,
    eta: float,
) -> float:
    """Return the relative error of W by the rule."""
    setting, value, level = result.setting, float(error.value), result.mean("level")
    omega = 2 * math.pi * setting.frequency
    match error.kind:
        case "cycles":
            turn = 2 * math.pi * value
            return math.sin(2 * turn) / (2 * turn) - math.sin(turn) ** 2 / (turn * eta)
        case "coil":
            return math.pi * value * level**2 / omega**3 / true
        case "offset":
            return 2 * value / eta
        case "friction":
            moved = setting.box_mass + setting.gauge_mass + setting.bed_mass
            return 4 * value * moved * (error.gravity or 0.0) * level / omega**2 / true
        case "corners":
            # |1/(1 - j fc/f)| = 1 - (fc/f)^2/2 to second order, for each of the two amplitudes
            reduced = sum((corner / setting.frequency) ** 2 for corner in _corners(error)) / 2
            return _lead("corners", result, error, channels) / eta - reduced
        case kind:
            return _lead(kind, result, error, channels) / eta


def _corners(error: SessionDeliberateError) -> tuple[float, float]:
    """Return the corners of the force's and the acceleration's AC coupling, Hz."""
    corner = error.corner or 0.0
    return corner, corner * (1 + float(error.value))


def _lead(
    kind: str, result: Result, error: SessionDeliberateError, channels: Mapping[str, ChannelFacts]
) -> float:
    """Return the phase by which the acceleration leads because of the error, rad; its mean over the
    record where it slides.
    """
    setting, value = result.setting, float(error.value)
    omega = 2 * math.pi * setting.frequency
    if kind == "pole":
        certified = channels["acceleration"].time_constant
        return (
            0.0
            if certified is None
            else pole_phase(omega, value * certified) - pole_phase(omega, certified)
        )
    if kind == "corners":
        force, acceleration = _corners(error)
        return math.atan(acceleration / setting.frequency) - math.atan(force / setting.frequency)
    if kind == "skew":
        return -omega * (error.delay or 0.0)
    return (
        -omega
        * 1e-6
        * value
        * (setting.settle_cycles + setting.record_cycles / 2)
        / setting.frequency
    )
