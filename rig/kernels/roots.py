"""One step of a root search that cannot fail: Halley's method inside the bracket, bisection
otherwise.
"""

from daq.compiled import njit

NEAR = 0.01
"""Step, rad (or fraction of the flight time, if that is shorter), within which a Taylor series of
order 7 is exact: d^7/7! < 1e-17.

It is divided by the number of harmonics. A root this close is finished on the series, without
another sine.
"""

EXACT = 1e-17
"""Largest error, in the same measure, after a step on the series: half its square times curvature
over slope.
"""

TIGHT = 1e-15
"""Width of a bracket, in the same measure, at the limit of bisection."""


@njit(cache=True, nogil=True, inline="always")
def halley(
    t: float, lo: float, hi: float, f: float, slope: float, curvature: float
) -> tuple[float, bool]:
    """Return the next trial point for the root of a falling function in [lo, hi], and whether it is
    Halley's.

    f, slope and curvature are taken at t. Where the slope would change by more than itself within
    the step, Newton's step replaces Halley's, which vanishes with the slope whether or not there is
    a root. A function that does not fall at t, or a step out of the bracket, gives the midpoint.
    """
    # |f f''| > f'^2: the slope changes by more than itself within a Newton step.
    square, bend = slope * slope, 0.5 * f * curvature
    if abs(bend) > 0.5 * square:
        bend = 0.0
    # Halley: t - f f'/(f'^2 - f f''/2). A point outside the bracket stands for "no step".
    new = t - f * slope / (square - bend) if slope < 0.0 and square > 0.0 else lo - 1.0
    inside = lo <= new <= hi
    return (new if inside else 0.5 * (lo + hi)), inside
