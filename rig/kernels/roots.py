"""One step of a root search that cannot fail: Halley's inside the bracket, bisection elsewhere."""

from numba import njit

NEAR = 0.01
"""Step, rad (or share of a flight's time, if shorter), over which a Taylor series of order 7 is exact: d^7/7! < 1e-17.

Divided by the number of harmonics. A root found to be so near is finished on the series, without
another sine.
"""

EXACT = 1e-17
"""Error, in the same measure, that a step on the series may leave: half its square times curvature over slope."""

TIGHT = 1e-15
"""Width of a bracket, in the same measure, at which bisection has nothing left to halve."""


@njit(cache=True, nogil=True, inline="always")
def halley(t: float, lo: float, hi: float, f: float, slope: float, curvature: float) -> tuple[float, bool]:
    """Next place to look for the root of a falling function in [lo, hi], from t where it is f; whether it is Halley's.

    Where the slope changes by more than itself on the way, Newton's step is taken: Halley's vanishes with the slope,
    root or not. A function that does not fall at t, or a step out of the bracket, gives the bracket's middle.
    """
    square, bend = slope * slope, 0.5 * f * curvature
    if abs(bend) > 0.5 * square:
        bend = 0.0
    new = t - f * slope / (square - bend) if slope < 0.0 and square > 0.0 else lo - 1.0
    inside = lo <= new <= hi
    return (new if inside else 0.5 * (lo + hi)), inside
