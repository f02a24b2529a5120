"""References: quantities that are known without a model of the bed, against their measured values.

Rigid mass: the empty box, and grains bonded to it, have F/a = their mass (the null tests judge the
phase); where the acceleration is read at the far end of the stinger, the stinger is corrected
first. Dashpot: W less that of the empty box at the same levels is pi c a^2/w^3. Phase: where the
rig's own ledger is known, W_exp of rigid masses differs from it by one scale and one angle. In a
light box whose losses exceed its inertia, an angle of milliradians stays hidden both in W, known to
1.6 %, and in a null test of few runs, but it shows in the way W_exp differs from level to level.
Signs: masses and energies are positive, and force and acceleration have the magnitude that was set.
"""

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.comparison.family_of_tests import Reference, Zero, sign_tests
from analysis.results.condition import Result
from analysis.results.run import RunEnergy
from analysis.session.record import ChannelFacts
from analysis.session.setting import Setting
from analysis.uncertainty.budget import (
    ANGLE_RESOLUTION,
    CERTIFICATE_NU,
    RESOLUTION,
    certificate_lines,
    combine,
    resolution_lines,
    scatter_line,
)
from analysis.uncertainty.estimate import Estimate

__all__ = ["references", "signs"]

SWAPPED = "force and acceleration seem swapped"
REVERSED = "a sign is reversed: the apparent mass is negative"
NEGATIVE = "a sign is reversed or a channel is late: the dissipated energy is negative"


def references(
    results: Sequence[Result], channels: Mapping[str, ChannelFacts]
) -> tuple[Reference, ...]:
    """Return all references that the conditions allow, except the signs."""
    rigid: dict[tuple[Any, ...], list[Result]] = defaultdict(list)
    damped: dict[tuple[Any, ...], list[Result]] = defaultdict(list)
    empty = {_level(r.setting): r for r in results if r.setting.is_empty}
    for result in results:
        setting = result.setting
        known = setting.box_mass + setting.gauge_mass + setting.bed_mass > 0
        if known and (setting.is_empty or setting.is_bonded):
            of = "empty box" if setting.is_empty else "bonded bed"
            rigid[of, setting.bed_mass, setting.frequency, *setting.places].append(result)
        elif (
            setting.bed == "dashpot"
            and setting.dashpot_c is not None
            and not setting.through_stinger
        ):
            damped[setting.dashpot_c, setting.frequency, *setting.places].append(result)
    return (
        *(_mass(of, found, channels) for (of, *_), found in rigid.items() if _reads_the_box(found)),
        *(_dashpot(c, found, empty, channels) for (c, *_), found in damped.items()),
        *(_phase(found) for found in _rigid_with_ledger(results) if len(found) > 1),
    )


def _rigid_with_ledger(results: Sequence[Result]) -> Iterable[list[Result]]:
    """Return the conditions in which nothing slides and whose losses are known, grouped by
    frequency and position of the instruments.
    """
    groups: dict[tuple[Any, ...], list[Result]] = defaultdict(list)
    for result in results:
        setting = result.setting
        if (
            result.chain is not None
            and (setting.is_empty or setting.is_bonded)
            and not setting.through_stinger
        ):
            groups[setting.frequency, *setting.places].append(result)
    return groups.values()


def _phase(results: Sequence[Result]) -> Reference:
    """Return the angle in W_exp - ledger = (scales) W + angle R, R = (pi/w^2) M_eff a^2, of at
    least two conditions.

    Generalised least squares: the scales, and the other errors within the certificates, are common
    to all conditions; noise and arithmetic are each condition's own. Where W/R is the same in all,
    angle and scale cannot be distinguished, and u is large.
    """
    apart = np.array([result.chain.value for result in results if result.chain is not None])
    W, R = (np.array([result.mean(name) for result in results]) for name in ("W", "reactive"))
    noise = [
        math.hypot(*(run.u_noise for run in result.runs)) / len(result.runs) for result in results
    ]
    covariance = np.diag(np.square(noise) + (RESOLUTION * W) ** 2 + (ANGLE_RESOLUTION * R) ** 2)
    scales: dict[str, NDArray[np.float64]] = defaultdict(lambda: np.zeros(len(results)))
    angles: dict[str, tuple[float, float]] = {}
    for i, result in enumerate(results):
        for line in (line for line in result.lines if line.shared):
            scales[line.source][i] = (line.c - line.turn * R[i]) * line.u
            angles[line.source] = line.turn * line.u, line.nu
    for part in scales.values():
        covariance += np.outer(part, part)
    weighted = np.linalg.solve(covariance, R)
    angle, fitted = float(weighted @ apart / (weighted @ R)), float(weighted @ R) ** -0.5
    u = combine(angle, [(fitted, math.inf), *angles.values()])
    shared = {source: part for source, (part, _) in angles.items()}
    of = f"rigid, {results[0].setting.frequency:g} Hz"
    return _held(
        "phase",
        of,
        "rad",
        angle,
        0.0,
        u,
        f" (W_exp against the ledger of {len(results)} conditions)",
        shared,
    )


def _level(setting: Setting) -> tuple[Any, ...]:
    """Return the settings that the empty box must share with a condition to serve as its tare."""
    return setting.frequency, setting.acceleration_set, *setting.places


def _reads_the_box(results: Sequence[Result]) -> bool:
    """Return whether the readings describe the box: not through a stinger of unknown properties."""
    return not results[0].setting.through_stinger or all(
        r.at_box is not None for each in results for r in each.runs
    )


def _held(
    reference: str, of: str, unit: str, value: float, expected: float, u: Estimate, note: str,
    shared: Mapping[str, float],
) -> Reference:  # fmt: skip
    """Return a reference with its verdict within its own U.

    u: uncertainty of `value`; shared: standard uncertainties from inputs of other tests, by name.
    """
    inside = abs(value - expected) <= u.U
    verdict = "holds" if inside else "undecided"
    side = "within" if inside else "beyond"
    why = f"{value:.5g} {unit} against {expected:.5g} {unit}, {side} U = {u.U:.2g} {unit}{note}"
    tested = (Zero(replace(u, value=value - expected), shared),)
    return Reference(reference, of, unit, value, expected, u.U, verdict, why, tested)


def _mass(of: str, results: Sequence[Result], channels: Mapping[str, ChannelFacts]) -> Reference:
    """Return the reference of a rigid mass, from F/a of all runs."""
    setting = results[0].setting
    runs = [run for result in results for run in result.runs]
    at_box = (
        [run.at_box for run in runs if run.at_box is not None] if setting.through_stinger else []
    )
    masses = [one.M_eff for one in at_box] or [run.energy.M_eff for run in runs]
    mean = math.fsum(masses) / len(masses)
    force, acceleration = channels["force"], channels["acceleration"]
    # M = Re F/A is proportional to the ratio of the channels, and depends on their angle as eta does.
    eta = math.fsum(run.energy.eta for run in runs) / len(runs)
    lines = certificate_lines(force, acceleration, setting.frequency, mean, 0.0)
    scales = {
        line.source: (line.u * (line.ratio - line.turn * eta) * mean, line.nu)
        for line in lines
        if line.ratio or line.turn
    }
    expected, where = setting.box_mass + setting.gauge_mass + setting.bed_mass, ""
    if at_box:
        expected, where = expected - setting.gauge_mass, ", brought to the box"
        scales["stinger stiffness"] = (
            math.fsum(one.M_stiffness for one in at_box) / len(at_box),
            CERTIFICATE_NU,
        )
    scatter = [(line.part, line.nu) for line in scatter_line(masses)]
    # Losses of a distorted motion that look like mass: a bound, so rectangular.
    bent = math.fsum(abs(run.energy.eta) * _bending(run) for run in runs) / len(runs) * mean
    u = combine(
        mean,
        [
            *scales.values(),
            *scatter,
            (RESOLUTION * mean, math.inf),
            (bent / math.sqrt(3), math.inf),
        ],
    )
    shared = {source: part for source, (part, _) in scales.items()}
    found = _held(
        "rigid mass", of, "kg", mean, expected, u, f" (F/a over {len(masses)} runs{where})", shared
    )
    # U of a single filling lacks the scatter between fillings: it may be beyond U, and fails nothing.
    return replace(found, tested=()) if setting.is_bonded and len(masses) == 1 else found


def _bending(run: RunEnergy) -> float:
    """Return the fraction of a loss that a distorted motion may turn into what looks like mass.

    A force k v|v| on v = V (cos t + e cos(3t + p)) has at most 0.6 e of its fundamental a quarter
    of a cycle away, other harmonics less, and a force k v nothing. e is taken from all harmonics of
    the velocity.
    """
    a = np.abs(run.energy.acceleration)
    velocity = a / np.arange(1, a.size + 1)
    return (
        float(0.6 * np.linalg.norm(velocity[1:]) / velocity[0])
        if a.size > 1 and velocity[0]
        else 0.0
    )


def _dashpot(
    c: float, results: Sequence[Result], empty: Mapping[tuple[Any, ...], Result],
    channels: Mapping[str, ChannelFacts],
) -> Reference:  # fmt: skip
    """Return the reference of a dashpot of coefficient c (N s/m), less the empty box at the same
    levels.
    """
    frequency = results[0].setting.frequency
    omega = 2 * math.pi * frequency
    n = len(results)
    tares = [empty.get(_level(result.setting)) for result in results]
    known = [tare for tare in tares if tare is not None]
    whole = len(known) == n
    squares = [math.fsum(run.energy.level**2 for run in r.runs) / len(r.runs) for r in results]
    # Closed form of a dashpot on a sine: pi c w X^2 = pi c a^2/w^3.
    expected = math.fsum(math.pi * c * square / omega**3 for square in squares) / n
    own = math.fsum(_less(r, tare, "W") for r, tare in zip(results, tares, strict=True)) / n
    reactive = (
        math.fsum(_less(r, tare, "reactive") for r, tare in zip(results, tares, strict=True)) / n
    )
    lines = (
        *certificate_lines(
            channels["force"], channels["acceleration"], frequency, own, reactive, expected, 2.0
        ),
        *resolution_lines(own, reactive),
    )
    scatter = [
        line for r in (*results, *known) for line in scatter_line([run.energy.W for run in r.runs])
    ]
    u = combine(
        own - expected,
        [
            *((line.part - line.part_T, line.nu) for line in lines),
            *((line.part / n, line.nu) for line in scatter),
        ],
    )
    note = (
        "; the empty box's is taken off"
        if whole
        else "; no empty box was measured at every one of its levels"
    )
    shared = {line.source: line.part - line.part_T for line in lines}
    found = _held("dashpot", f"c = {c:g} N s/m", "J", own, expected, u, note, shared)
    # Without the empty box its own losses are part of the value, which then fails nothing.
    return found if whole else replace(found, tested=())


def _less(result: Result, tare: Result | None, name: str) -> float:
    """Return the mean of an energy less the empty box's, scaled to the same level by a^2."""
    own = result.mean(name)
    return (
        own
        if tare is None
        else own - tare.mean(name) * (result.mean("level") / tare.mean("level")) ** 2
    )


def signs(results: Sequence[Result], limit: float) -> Reference:
    """Return the signs of at least one condition; limit: critical score of the family, for energies
    below zero.
    """
    runs = [(run, result.setting) for result in results for run in result.runs]
    swapped = [run.run for run, setting in runs if _swapped(run, setting)]
    negative = [run.run for run, _ in runs if run.energy.M_eff < 0]
    late = [
        r.setting.id
        for r, test in zip(results, sign_tests(results), strict=True)
        if test.score > limit
    ]
    why = "masses and energies are positive, force and acceleration of the size that was set"
    verdict = "does not hold" if swapped or negative or late else "holds"
    if swapped:
        why = f"{SWAPPED} in {len(swapped)} of {len(runs)} runs, the first is {swapped[0]}"
    elif negative:
        why = f"{REVERSED} in {len(negative)} of {len(runs)} runs, the first is {negative[0]}"
    elif late:
        why = f"{NEGATIVE} in {len(late)} of {len(results)} conditions, the first is {late[0]}"
    return Reference("signs", "all runs", "", None, None, None, verdict, why)


def _swapped(run: RunEnergy, setting: Setting) -> bool:
    """Return whether the two channels are exchanged.

    Then |F| has the magnitude of the acceleration that was set, and |a| that of the force. Their
    geometric mean decides, provided that the box is heavy enough (4 kg) for the two to differ.
    """
    mass = setting.box_mass + setting.gauge_mass
    middle = setting.acceleration_set * math.sqrt(mass)
    return mass >= 4 and run.energy.level > middle > abs(complex(run.energy.force[0]))
