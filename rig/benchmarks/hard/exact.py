"""Forty-digit arithmetic and event-by-event motion in it, the reference for the compiled kernels.

Units of the waveform: the box has acceleration -sin t. A slider against it has z' = sin t - c while
it slides or flies; c is s (the direction, +-1) times its friction, or a gravity. Nothing here is
shared with `rig`.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager
from decimal import Context, Decimal, localcontext
from typing import NamedTuple

DIGITS = 40
TINY = Decimal(10) ** -30
PI = Decimal("3.14159265358979323846264338327950288419716939937510")

Function = Callable[[Decimal], Decimal]


def precise() -> AbstractContextManager[Context]:
    """Return the context of forty digits in which this module's functions must be called."""
    return localcontext(Context(prec=DIGITS))


def cosine_and_sine(x: Decimal) -> tuple[Decimal, Decimal]:
    """Return cos x and sin x by their series, after subtracting whole turns."""
    with localcontext() as context:
        context.prec = DIGITS + 10
        x = x - 2 * PI * (x / (2 * PI)).to_integral_value()
        square, cos, sin, term, n = x * x, Decimal(1), x, x, 1
        even = Decimal(1)
        while abs(term) > TINY * TINY:
            even = -even * square / ((2 * n - 1) * (2 * n))
            term = -term * square / ((2 * n) * (2 * n + 1))
            cos, sin, n = cos + even, sin + term, n + 1
        return cos, sin


def root(function: Function, low: Decimal, high: Decimal) -> Decimal:
    """Return the root in a bracket with a change of sign, by bisection and secant in turn, to 30
    digits.
    """
    f_low, f_high = function(low), function(high)
    if f_low * f_high > 0:
        raise ArithmeticError("no change of sign in the bracket")
    while high - low > TINY:
        for at in (
            (low * f_high - high * f_low) / (f_high - f_low) if f_high != f_low else low,
            (low + high) / 2,
        ):
            if not low < at < high:
                continue
            value = function(at)
            if value == 0:
                return at
            if (value > 0) == (f_high > 0):
                high, f_high = at, value
            else:
                low, f_low = at, value
    return (low + high) / 2


class Flight(NamedTuple):
    """Free motion against the box from phase t0, position u and velocity z, with constant c."""

    t0: Decimal
    u: Decimal
    z: Decimal
    c: Decimal

    def position(self, t: Decimal) -> Decimal:
        """Return u at a phase: u0 + (z0 + cos t0)(t - t0) - (sin t - sin t0) - c (t - t0)^2/2."""
        cos0, sin0 = cosine_and_sine(self.t0)
        past = t - self.t0
        return (
            self.u
            + (self.z + cos0) * past
            - (cosine_and_sine(t)[1] - sin0)
            - self.c * past * past / 2
        )

    def velocity(self, t: Decimal) -> Decimal:
        """Return z at a phase: z0 + cos t0 - cos t - c (t - t0)."""
        cos0, _ = cosine_and_sine(self.t0)
        return self.z + cos0 - cosine_and_sine(t)[0] - self.c * (t - self.t0)

    def first(self, function: Function, step: Decimal, last: Decimal) -> Decimal | None:
        """Return the first phase after t0 at which a function of the phase is no longer positive;
        None if there is none up to `last`.
        """
        t = self.t0
        while t < last:
            after = min(t + step, last)
            if function(after) <= 0:
                return root(
                    function, t if t > self.t0 else self.t0 + (after - self.t0) / 2**20, after
                )
            t = after
        return None


class Bounces(NamedTuple):
    """Bouncing against one wall until it dies out: phase of the last contact, energy lost per mass,
    hits.
    """

    phase: Decimal
    lost: Decimal
    hits: int


def bounces(t: Decimal, z: Decimal, c: Decimal, restitution: Decimal, least: Decimal) -> Bounces:
    """Return the bounces of a mass that hits the wall at u = 0 at speed z, until a rebound is below
    `least`; every hit is exact.

    The push z' = sin t - c must be towards the wall (negative) throughout, so that a flight is
    concave and its return unique. The search starts beyond it, at one and a half times 2 z/|push|,
    doubled if needed.
    """
    lost, hits = Decimal(0), 0
    while True:
        rebound = restitution * z
        lost += (z * z - rebound * rebound) / 2
        hits += 1
        if rebound < least:
            return Bounces(t, lost + rebound * rebound / 2, hits)
        flight = Flight(t, Decimal(0), rebound, c)
        push = c - cosine_and_sine(t)[1]
        if push <= 0:
            raise ArithmeticError("the mass is thrown off while it bounces")
        at = 3 * rebound / push
        while flight.position(t + at) > 0:
            at *= 2
        # Newton from beyond the root of a concave function converges without overshoot
        for _ in range(8):
            at -= flight.position(t + at) / flight.velocity(t + at)
        t += at
        z = -flight.velocity(t)


def arcsine(x: Decimal) -> Decimal:
    """Return the phase in [0, pi/2] whose sine is x, for x in [0, 1)."""
    return root(lambda t: cosine_and_sine(t)[1] - x, Decimal(0), PI / 2) if x > 0 else Decimal(0)


STEP = Decimal("0.05")


def plastic_row(band: Decimal, clearance: Decimal, cycles: int) -> list[Decimal]:
    """Return the energy lost per mass in each cycle by a row with friction `band` > 0 in a free
    clearance, plastic at both ends.

    From rest at u = 0 it waits for a push beyond the band, slides, and stops where z = 0 or at an
    end wall.
    """
    end = 2 * PI * cycles
    t, u, lost = Decimal(0), Decimal(0), [Decimal(0) for _ in range(cycles)]
    up = arcsine(band)
    while t < end:
        # just after the phase for which the row has waited
        turn = t - 2 * PI * (t // (2 * PI)) + TINY
        s = Decimal(0)
        if up < turn < PI - up:
            s = Decimal(1)
        elif PI + up < turn < 2 * PI - up:
            s = Decimal(-1)
        if s == 0 or (s > 0 and u == clearance) or (s < 0 and u == 0):
            t += (
                next(phase for phase in (up, PI + up, 2 * PI + up, 3 * PI + up) if phase > turn)
                - turn
                + TINY
            )
            continue
        flight = Flight(t, u, Decimal(0), s * band)
        wall = clearance if s > 0 else Decimal(0)
        stop = flight.first(lambda at, f=flight, s=s: s * f.velocity(at), STEP, t + 4 * PI)  # type: ignore[misc]
        hit = flight.first(
            lambda at, f=flight, s=s, w=wall: s * (w - f.position(at)),  # type: ignore[misc]
            STEP,
            stop or t + 4 * PI,
        )
        t = end if stop is None else stop
        if hit is not None:
            t = hit
        if t >= end:
            break
        after = wall if hit is not None else flight.position(t)
        speed = flight.velocity(t) if hit is not None else Decimal(0)
        lost[int(t / (2 * PI))] += band * s * (after - u) + speed * speed / 2
        u = after
    return lost


class Landed(NamedTuple):
    """A single mass after some cycles: the energy lost in each, and its height and velocity at the
    end (0, 0: at rest).
    """

    lost: list[Decimal]
    u: Decimal
    z: Decimal


def single_mass_on_floor(weight: Decimal, cycles: int, u: Decimal, z: Decimal) -> Landed:
    """Return the motion of a plastic single mass over a floor without a lid, weight < 1.

    u, z: height and velocity at phase 0 (0, 0: at rest).
    """
    end = 2 * PI * cycles
    t, lost = Decimal(0), [Decimal(0) for _ in range(cycles)]
    up = arcsine(weight)
    while t < end:
        # Rest of the time in which the floor accelerates away faster than the single mass can fall.
        left = PI - up - (t - 2 * PI * (t // (2 * PI)) + TINY)
        if u == 0 and z == 0 and not 0 < left < PI - 2 * up:
            t += left + 2 * up - PI + TINY if left >= PI - 2 * up else left + PI + 2 * up + TINY
            continue
        flight = Flight(t, u, z, weight)
        step = min(STEP, left / 4) if u == 0 else STEP
        t = flight.first(flight.position, step, end) or end
        if t >= end:
            return Landed(lost, flight.position(end), flight.velocity(end))
        lost[int(t / (2 * PI))] += flight.velocity(t) ** 2 / 2
        u = z = Decimal(0)
    return Landed(lost, Decimal(0), Decimal(0))
