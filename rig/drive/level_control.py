"""Level control of a dwell: the next command from the phasors of the measured cycles.

The loop multiplies the fundamental of the command by (target/level)^(gain/slope). A linear exciter
has slope 1. A bed that starts to slide makes the box lighter and the slope steeper, so the slope is
estimated from the last two levels. Far from the target every cycle corrects. Near it the level is
averaged first: impacts scatter it from cycle to cycle under a constant command (6 % at 5 m/s^2),
and the mean is what is recorded. The apparent mass can fall too fast for any slope; such a jump is
counted. Harmonics, if controlled, are driven towards zero through the response of the box alone. A
limit of the exciter, once reached, stops the command.
"""

import cmath
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

__all__ = ["Loop", "Target", "started", "stepped"]

Status = Literal["seeking", "reached", "limited", "timed out"]
Phasors = tuple[complex, ...]

GAIN = 0.5
"""Fraction of the level error (log units) corrected per cycle far from the target."""

LEAD = 0.6
"""Lag compensation: fraction of the last log-level step expected to recur, because exciter and bed
respond about one cycle late.
"""

FINE_GAIN = 0.9
"""Fraction of the level error (log units) corrected per mean near the target."""

NEAR = math.log(1.04)
"""Level error (log units) below which, plus twice the scatter, the level is averaged before a
correction.
"""

LEAST = 4
"""Smallest window, in cycles, that gives a mean and its scatter: the first two cycles are
transient.
"""

STEEPEST = 4.0
"""Upper bound of the estimated slope dln(level)/dln(command)."""

STEEP_NEAR = 1.5
"""Upper bound of the slope near the target, where slow transients look like a slope."""

LONGEST_STEP = math.log(1.5)
"""Largest change of the command per cycle (log units)."""

JUMP = math.log(1.25)
JUMP_SLOPE = 2.0
"""A level change in one cycle counts as a jump if it exceeds this slope times the command change by
`JUMP` (log units).
"""

AIM = 0.7
"""Fraction of the tolerance within which a mean is accepted; the rest is reserved for
slow drift.
"""

PATIENCE = 18
"""Cycles after which the whole tolerance, or the standard error of the mean, is accepted: every
further correction would start a new mean.
"""

AT_LIMIT = 0.99
"""Utilisation of a limit above which the command is no longer raised."""

OVER_LIMIT = 1.01
"""Utilisation of a limit above which the command is reduced."""


@dataclass(frozen=True)
class Target:
    """Target of a dwell: amplitude of the fundamental acceleration, m/s^2, with a relative
    tolerance.

    hold : least number of cycles whose mean counts as the level
    longest : number of cycles after which a mean with more scatter than the tolerance is accepted,
        within its standard error
    timeout : cycles after which the loop gives up
    phase : angle of the acceleration relative to the command's clock, rad; None leaves it free
    flat : largest accepted ratio of the rms of the controlled harmonics to the fundamental
    """

    level: float
    tolerance: float = 0.01
    hold: int = 6
    longest: int = 8
    timeout: int = 60
    phase: float | None = None
    flat: float = 0.02


@dataclass(frozen=True)
class Loop:
    """State of the control loop: the command's phasors (harmonics 1, 2, ...) and the measured
    history.

    cycles, level : cycles measured so far, and the latest mean of the level, m/s^2
    slope : latest estimate of dln(level)/dln(command)
    limit : exciter limit met on the way to a level that is not reached, "" for none
    scatter : relative scatter of the level from cycle to cycle under a constant command
    jumps : number of cycles in which the level changed by more than any slope explains
    window : measured phasors of the cycles since the last change of command; if the level scatters,
        also those before it, scaled to the new command
    fresh : cycles since the last change of command
    before : level and command before that change
    """

    command: Phasors
    status: Status = "seeking"
    cycles: int = 0
    level: float = 0.0
    slope: float = 1.0
    limit: str = ""
    scatter: float = 0.0
    jumps: int = 0
    window: tuple[Phasors, ...] = ()
    fresh: int = 0
    before: tuple[float, float] = (0.0, 0.0)


def started(guess: complex, harmonics: int = 1) -> Loop:
    """Return a loop at rest with a first fundamental of `guess` (V or A) that controls `harmonics`
    harmonics.
    """
    return Loop((guess, *(0j,) * (harmonics - 1)))


def stepped(
    loop: Loop, target: Target, measured: Sequence[complex], shares: Mapping[str, float],
    response: Sequence[complex] = (),
) -> Loop:  # fmt: skip
    """Return the loop after one more cycle, with the command for the next.

    measured : phasors of the box acceleration over the last cycle (m/s^2), harmonics 1, 2, ...
    shares : used fraction of each exciter limit in that cycle, by name
    response : acceleration of the box alone per unit command at each harmonic; for controlled
        harmonics only
    """
    jumped, swing = _jumped(loop, measured[0]), _swing(loop, abs(measured[0]), target.level)
    window = (*loop.window, tuple(measured))
    loop = replace(
        loop, window=window, cycles=loop.cycles + 1, jumps=loop.jumps + jumped, fresh=loop.fresh + 1
    )
    means, scatter = _mean(window)
    scatter = scatter if len(window) >= LEAST else max(loop.scatter, swing)
    loop = replace(loop, level=abs(means[0]), scatter=scatter)
    error = math.log(target.level / loop.level) if loop.level > 0.0 else LONGEST_STEP
    doubt = loop.scatter / math.sqrt(max(len(window) - 2, 1))
    sure = doubt <= 0.5 * target.tolerance
    # The mean of `longest` scattering cycles cannot be distinguished from the target within its own
    # standard error.
    late = loop.cycles > PATIENCE
    taken = late or len(window) > target.longest
    inside = abs(error) <= max(
        math.log1p((1.0 if late else AIM) * target.tolerance), doubt if taken else 0.0
    )
    far = abs(error) > NEAR + 2.0 * loop.scatter
    full = loop.fresh > (target.hold if inside and not late else LEAST - 1) and (sure or taken)
    if full and inside and _distortion(means, loop.command) <= target.flat:
        return replace(loop, status="reached", limit="")
    # A limit matters only if the level is still too low: a falling command leaves it by itself.
    stuck = _at_limit(shares) if error > 0.0 and not inside else ""
    if stuck:
        loop = replace(loop, limit=stuck)
    if stuck and full and shares[stuck] <= OVER_LIMIT:
        return replace(loop, status="limited")
    if loop.cycles >= target.timeout:
        return replace(loop, status="timed out")
    if stuck and shares[stuck] <= OVER_LIMIT:
        return loop
    if not (far or full or stuck):
        return loop
    return _changed(loop, target, means, error, shares[stuck] if stuck else 0.0, far, response)


def _changed(
    loop: Loop,
    target: Target,
    means: Phasors,
    error: float,
    used: float,
    far: bool,
    response: Sequence[complex],
) -> Loop:
    """Return the loop with a new command and a new window."""
    slope = _slope(loop, far)
    rising = _rising(loop) if far else 0.0
    step = max(
        -LONGEST_STEP,
        min(LONGEST_STEP, (GAIN if far else FINE_GAIN) / slope * (error - LEAD * rising)),
    )
    if used:  # down to the limit: what is then missing of the level is the limit's
        # Reduce the command to the limit; the remaining level error is due to the limit.
        step = max(-LONGEST_STEP, min(0.0, -math.log(used)))
    turn = 0.0
    if target.phase is not None:
        # Angle from the measured acceleration to the wanted phase.
        turn = GAIN * cmath.phase(cmath.exp(1j * target.phase) * means[0].conjugate())
    first = loop.command[0] * cmath.rect(math.exp(step), turn)
    others = (
        old - GAIN * seen / through
        for old, seen, through in zip(loop.command[1:], means[1:], response[1:], strict=False)
    )
    # A scattering level near the target is nearly linear in the command: rescaled cycles still
    # count.
    kept: tuple[Phasors, ...] = ()
    if not far and loop.scatter > target.tolerance:
        grown = math.exp(slope * step)
        kept = tuple(
            (grown * phasors[0], *phasors[1:]) for phasors in loop.window[-target.longest :]
        )
    before = (loop.level, abs(loop.command[0]))
    return replace(loop, command=(first, *others), slope=slope, window=kept, fresh=0, before=before)


def _rising(loop: Loop) -> float:
    """Return the change of the level in the latest cycle (log units)."""
    latest = abs(loop.window[-1][0])
    was = abs(loop.window[-2][0]) if len(loop.window) > 1 else loop.before[0]
    return math.log(latest / was) if min(latest, was) > 0.0 else 0.0


def _mean(window: tuple[Phasors, ...]) -> tuple[Phasors, float]:
    """Return the mean phasors of a window and the relative scatter of its level.

    The first two cycles, in which command and exciter are still in transition, are left out.
    """
    used = window[2:] or window[-1:]
    n = len(used)
    means = tuple(sum(column) / n for column in zip(*used, strict=True))
    levels = [abs(phasors[0]) for phasors in used]
    middle = math.fsum(levels) / n
    spread = math.sqrt(math.fsum((level - middle) ** 2 for level in levels) / max(n - 1, 1))
    return means, spread / middle if middle else 0.0


def _swing(loop: Loop, level: float, aim: float) -> float:
    """Scatter estimate when the level overshoots the target by more than the command change
    explains: half the overshoot (log units).
    """
    was, drove = loop.before
    if loop.fresh or min(was, drove, level) <= 0.0 or (was - aim) * (level - aim) >= 0.0:
        return 0.0
    moved = abs(math.log(level / was)) - STEEP_NEAR * abs(math.log(abs(loop.command[0]) / drove))
    return max(0.5 * moved, 0.0)


def _jumped(loop: Loop, first: complex) -> bool:
    """Return whether the level of this cycle differs from the previous one by more than any slope
    explains.
    """
    was = abs(loop.window[-1][0]) if loop.fresh else loop.before[0]
    if was <= 0.0 or first == 0.0:
        return False
    drove = 0.0 if loop.fresh else loop.before[1]
    raised = abs(math.log(abs(loop.command[0]) / drove)) if drove else 0.0
    return abs(math.log(abs(first) / was)) > JUMP + JUMP_SLOPE * raised


def _slope(loop: Loop, moving: bool) -> float:
    """Return dln(level)/dln(command) from this command and the previous one.

    While the level is `moving`, the result is averaged with the previous estimate.
    """
    level, drive = loop.before
    if min(level, drive, loop.level) <= 0.0:
        return loop.slope
    raised = math.log(abs(loop.command[0]) / drive)
    # A quotient of two small changes is noise.
    if abs(raised) < 0.01:
        return loop.slope
    found = max(1.0, math.log(loop.level / level) / raised)
    return 0.5 * (loop.slope + min(found, STEEPEST)) if moving else min(found, STEEP_NEAR)


def _distortion(means: Phasors, command: Phasors) -> float:
    """Return the ratio of the rms of the controlled harmonics to the fundamental."""
    return math.sqrt(math.fsum(abs(x) ** 2 for x in means[1 : len(command)])) / abs(means[0])


def _at_limit(shares: Mapping[str, float]) -> str:
    """Return the name of the limit with the highest utilisation if it is reached, "" otherwise."""
    most = max(shares, key=lambda name: shares[name], default="")
    return most if most and shares[most] >= AT_LIMIT else ""
