"""Level control of a dwell, as a law over measured cycles: the next command from the last cycles' phasors.

The loop multiplies the command's fundamental by (target/level)^(gain/slope). A linear exciter has slope 1; a bed that
lets go makes the box lighter and the slope steeper, so it is estimated from the last two levels. Far from the target
every cycle corrects. Near it the level is averaged: impacts make it scatter from cycle to cycle under a constant
command (6 % at 5 m/s^2), and what is recorded is its mean. The apparent mass can fall so fast that no slope describes
it: such a jump is counted. Harmonics, where they are controlled, are driven towards zero through the response of the
box alone. A limit of the exciter stops the command where it is reached.
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
"""Share of the level error, in logarithms, that a cycle corrects far from the target."""

LEAD = 0.6
"""Share of the level's latest rise, in logarithms, that is expected once more: exciter and bed still follow the command
before."""

FINE_GAIN = 0.9
"""The same for a mean near the target."""

NEAR = math.log(1.04)
"""Level error below which the level is averaged before it is corrected, beside twice its scatter."""

LEAST = 4
"""Cycles of a window from which a mean and its scatter can be told: the first two still move."""

STEEPEST = 4.0
"""Largest slope dln(level)/dln(command) that the loop believes."""

STEEP_NEAR = 1.5
"""The same near the target, where slow transients look like a slope."""

LONGEST_STEP = math.log(1.5)
"""Largest change of the command in one cycle, in logarithms."""

JUMP = math.log(1.25)
JUMP_SLOPE = 2.0
"""A change of level in one cycle counts as a jump where it is `JUMP` beyond this slope times the command's change."""

AIM = 0.7
"""Share of the tolerance within which a mean is left as it is: a slow drift has room."""

PATIENCE = 18
"""Cycles after which the whole tolerance will do, or the mean's own standard error: no correction more that starts a
mean anew."""

AT_LIMIT = 0.99
"""Share of a limit from which on the command is not raised."""

OVER_LIMIT = 1.01
"""Share of a limit from which on the command is taken back."""


@dataclass(frozen=True)
class Target:
    """What a dwell is to reach: amplitude of the fundamental acceleration in m/s^2, within a relative tolerance.

    hold : cycles at least whose mean counts as the level; longest : cycles after which a mean that scatters more than
        the tolerance is taken as it is, good to its standard error
    timeout : cycles after which the loop gives up
    phase : angle of the acceleration against the command's clock, rad; None leaves it free
    flat : rms of the controlled harmonics over the fundamental that is flat enough
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
    """State of the loop: the command's phasors (harmonics 1, 2, ...) and what has been seen.

    cycles, level : measured so far, and the latest mean of the level, m/s^2
    slope : dln(level)/dln(command) as last estimated
    limit : the exciter's limit that was met on the way to a level that is not reached, "" for none
    scatter : of the level from cycle to cycle under a constant command, relative
    jumps : cycles in which the level changed more than any slope explains
    window : measured phasors of the cycles since the command changed; where the level scatters, those before it as
        well, scaled to the command
    fresh : cycles since the command changed
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
    """A loop at rest that will begin with a fundamental of `guess` (V or A) and control so many harmonics."""
    return Loop((guess, *(0j,) * (harmonics - 1)))


def stepped(
    loop: Loop, target: Target, measured: Sequence[complex], shares: Mapping[str, float],
    response: Sequence[complex] = (),
) -> Loop:  # fmt: skip
    """The loop after one more cycle, with the command for the next.

    measured : phasors of the box's acceleration over the last cycle (m/s^2), harmonics 1, 2, ...
    shares : of the exciter's limits that the cycle used, by name
    response : acceleration per command at each harmonic, of the box alone; for controlled harmonics only
    """
    jumped, swing = _jumped(loop, measured[0]), _swing(loop, abs(measured[0]), target.level)
    window = (*loop.window, tuple(measured))
    loop = replace(loop, window=window, cycles=loop.cycles + 1, jumps=loop.jumps + jumped, fresh=loop.fresh + 1)
    means, scatter = _mean(window)
    scatter = scatter if len(window) >= LEAST else max(loop.scatter, swing)
    loop = replace(loop, level=abs(means[0]), scatter=scatter)
    error = math.log(target.level / loop.level) if loop.level > 0.0 else LONGEST_STEP
    doubt = loop.scatter / math.sqrt(max(len(window) - 2, 1))
    sure = doubt <= 0.5 * target.tolerance
    # a mean of `longest` cycles that scatter is not told from the target within its own standard error
    late = loop.cycles > PATIENCE
    taken = late or len(window) > target.longest
    inside = abs(error) <= max(math.log1p((1.0 if late else AIM) * target.tolerance), doubt if taken else 0.0)
    far = abs(error) > NEAR + 2.0 * loop.scatter
    full = loop.fresh > (target.hold if inside and not late else LEAST - 1) and (sure or taken)
    if full and inside and _distortion(means, loop.command) <= target.flat:
        return replace(loop, status="reached", limit="")
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
    loop: Loop, target: Target, means: Phasors, error: float, used: float, far: bool, response: Sequence[complex]
) -> Loop:
    """The loop with a new command and an empty window."""
    slope = _slope(loop, far)
    rising = _rising(loop) if far else 0.0
    step = max(-LONGEST_STEP, min(LONGEST_STEP, (GAIN if far else FINE_GAIN) / slope * (error - LEAD * rising)))
    if used:  # down to the limit: what is then missing of the level is the limit's
        step = max(-LONGEST_STEP, min(0.0, -math.log(used)))
    turn = 0.0
    if target.phase is not None:
        turn = GAIN * cmath.phase(cmath.exp(1j * target.phase) * means[0].conjugate())
    first = loop.command[0] * cmath.rect(math.exp(step), turn)
    others = (
        old - GAIN * seen / through
        for old, seen, through in zip(loop.command[1:], means[1:], response[1:], strict=False)
    )
    kept: tuple[Phasors, ...] = ()
    if not far and loop.scatter > target.tolerance:
        grown = math.exp(slope * step)
        kept = tuple((grown * phasors[0], *phasors[1:]) for phasors in loop.window[-target.longest :])
    before = (loop.level, abs(loop.command[0]))
    return replace(loop, command=(first, *others), slope=slope, window=kept, fresh=0, before=before)


def _rising(loop: Loop) -> float:
    """Change of the level in the latest cycle, in logarithms."""
    latest = abs(loop.window[-1][0])
    was = abs(loop.window[-2][0]) if len(loop.window) > 1 else loop.before[0]
    return math.log(latest / was) if min(latest, was) > 0.0 else 0.0


def _mean(window: tuple[Phasors, ...]) -> tuple[Phasors, float]:
    """Mean phasors of a window and the relative scatter of its level; the first two cycles, in which command and
    exciter still move, do not count."""
    used = window[2:] or window[-1:]
    n = len(used)
    means = tuple(sum(column) / n for column in zip(*used, strict=True))
    levels = [abs(phasors[0]) for phasors in used]
    middle = math.fsum(levels) / n
    spread = math.sqrt(math.fsum((level - middle) ** 2 for level in levels) / max(n - 1, 1))
    return means, spread / middle if middle else 0.0


def _swing(loop: Loop, level: float, aim: float) -> float:
    """Scatter that a level shows which has crossed its aim by more than the command can have made it: half the way."""
    was, drove = loop.before
    if loop.fresh or min(was, drove, level) <= 0.0 or (was - aim) * (level - aim) >= 0.0:
        return 0.0
    moved = abs(math.log(level / was)) - STEEP_NEAR * abs(math.log(abs(loop.command[0]) / drove))
    return max(0.5 * moved, 0.0)


def _jumped(loop: Loop, first: complex) -> bool:
    """Whether the level of this cycle left the one before faster than any slope explains."""
    was = abs(loop.window[-1][0]) if loop.fresh else loop.before[0]
    if was <= 0.0 or first == 0.0:
        return False
    drove = 0.0 if loop.fresh else loop.before[1]
    raised = abs(math.log(abs(loop.command[0]) / drove)) if drove else 0.0
    return abs(math.log(abs(first) / was)) > JUMP + JUMP_SLOPE * raised


def _slope(loop: Loop, moving: bool) -> float:
    """dln(level)/dln(command) from this command and the one before; half of the old estimate stays where the level is
    still `moving`."""
    level, drive = loop.before
    if min(level, drive, loop.level) <= 0.0:
        return loop.slope
    raised = math.log(abs(loop.command[0]) / drive)
    if abs(raised) < 0.01:
        return loop.slope
    found = max(1.0, math.log(loop.level / level) / raised)
    return 0.5 * (loop.slope + min(found, STEEPEST)) if moving else min(found, STEEP_NEAR)


def _distortion(means: Phasors, command: Phasors) -> float:
    """rms of the controlled harmonics over the fundamental."""
    return math.sqrt(math.fsum(abs(x) ** 2 for x in means[1 : len(command)])) / abs(means[0])


def _at_limit(shares: Mapping[str, float]) -> str:
    """The limit that is used most, where it is reached; "" otherwise."""
    most = max(shares, key=lambda name: shares[name], default="")
    return most if most and shares[most] >= AT_LIMIT else ""
