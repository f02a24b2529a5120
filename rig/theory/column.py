"""Energy per cycle of a horizontal box of grains as a column of layers: prediction `column`.

A surface layer flows and the deep bed rides with the box: thresholds rise with depth, because walls
that slip along the drive cannot carry the weight as well. The formula was fitted to resolved grains
(docs/model.md, Column); no published closure with a stated accuracy was found for levels below 1 g.

Symbols: w fill, H height, L length along the drive, B width, d grain diameter, g gravity, a peak
acceleration, V = a/(2 pi f) peak velocity, M mass of the grains.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

FILLS = (0.3, 0.95)
"""Fills (settled height over height of the box) between which the formula is stated."""

LEVELS = (0.5, 2.0)
"""Levels a/g between which the formula is stated."""

TALL = 0.7
"""Level a/g below which a box taller than long is outside: the formula was 2.2 times too high."""

LEAST_FLOW = 1.0
"""Least depth of flow in grain diameters: the formula is a continuum's, and a single layer that
rocks on its neighbours is none.
"""

ROUNDING = 1e-9
"""Relative distance from the end of a range within which a value is at the end."""

COVERED = 1.645
"""Standard deviations of a normal distribution within which 90 % of its values lie."""

ERROR_FACTORS = ((0.5, 2.5), (0.7, 1.5), (math.inf, 1.3))
"""Upper end of a range of levels a/g, and the factor within which 90 % of the cases not fitted lie
there.
"""


@dataclass(frozen=True)
class YieldProfile:
    """Rise of the yield acceleration with depth, y = mu0 + h (dK/L + 2 mu_w_K/B), in units of g.

    mu0 : at the free surface
    dK : of the end walls, from the difference of passive and active stress
    mu_w_K : of each side wall
    """

    mu0: float
    dK: float
    mu_w_K: float

    def levels(self, depth: ArrayLike, length: float, width: float) -> Array:
        """Return the yield acceleration at a depth below the free surface (m), in units of g."""
        slope = self.dK / length + 2.0 * self.mu_w_K / width
        return np.asarray(self.mu0 + np.asarray(depth, dtype=np.float64) * slope)


@dataclass(frozen=True)
class ColumnCoefficients:
    """Coefficients of the formula: the rise of the yield acceleration, and the sharpness q of the
    change from riding to flowing.
    """

    profile: YieldProfile
    q: float


@dataclass(frozen=True)
class ColumnBed:
    """Grains in a rectangular box, SI units; `fill` is the settled height over `height`."""

    length: float
    width: float
    height: float
    diameter: float
    fill: float
    mass: float

    @property
    def layers(self) -> int:
        """Number of layers one grain high, round(w H/d); at least one unless the box is empty."""
        depth = self.fill * self.height
        return 0 if depth == 0.0 else max(round(depth / self.diameter), 1)

    @property
    def depths(self) -> Array:
        """Depth of the top of each layer below the free surface, m, top first, shape (layers,)."""
        layers = self.layers
        return np.arange(layers, dtype=np.float64) * (self.fill * self.height / max(layers, 1))


@dataclass(frozen=True, eq=False)
class ColumnTotal:
    """Response of a column at each level.

    W_T : energy per cycle, J
    in_phase_mass : mass that moves in phase with the box, kg
    amplitude : velocity amplitude of each layer over that of the box, top first, shape
        (..., layers)
    flow : depth of flow in grain diameters: velocity of the layers relative to the box over that
        of the box, summed over the layers
    """

    W_T: Array
    in_phase_mass: Array
    amplitude: Array
    flow: Array


def column_total(
    bed: ColumnBed,
    coefficients: ColumnCoefficients,
    acceleration: ArrayLike,
    frequency: float,
    gravity: float,
) -> ColumnTotal:
    """Return the response of a column to an exact sine at peak accelerations (m/s^2) of any shape.

    x = (4/pi) y g/a of a layer is the velocity amplitude that friction at its yield acceleration
    could give it, c = x/(1 + x^q)^(1/q) the one that it has. It lags by the angle whose cosine is
    c, so that it takes pi m V^2 c sqrt(1 - c^2) per cycle, at most pi/2 m V^2.
    """
    a = np.asarray(acceleration, dtype=np.float64)
    levels = coefficients.profile.levels(bed.depths, bed.length, bed.width)
    x = 4.0 / math.pi * gravity * levels / a[..., None]
    # 1 - c^q = 1/(1 + x^q), in a form that neither overflows nor cancels where layers ride.
    large = x >= 1.0
    power = np.where(large, x, 1.0 / x) ** -coefficients.q
    log_c = -np.log1p(power) / coefficients.q + np.where(large, 0.0, np.log(x))
    amplitude, relative = np.exp(log_c), np.sqrt(-np.expm1(2.0 * log_c))
    share = 1.0 / max(bed.layers, 1)
    velocity = a / (2.0 * math.pi * frequency)
    energy = math.pi * bed.mass * velocity**2
    return ColumnTotal(
        W_T=np.asarray(energy * share * (amplitude * relative).sum(axis=-1)),
        in_phase_mass=np.asarray(bed.mass * share * (amplitude**2).sum(axis=-1)),
        amplitude=amplitude,
        flow=np.asarray(relative.sum(axis=-1)),
    )


def relative_uncertainty(level: float) -> float:
    """Return the standard uncertainty of ln W_T at a level a/g, stated from cases not fitted.

    90 % of the ratios of formula and resolved grains lie within a factor F, so that u = ln F/1.645
    for a normal distribution of ln W.
    """
    factor = next(factor for end, factor in ERROR_FACTORS if level < end * (1.0 - ROUNDING))
    return math.log(factor) / COVERED


def outside(
    bed: ColumnBed,
    flow: float,
    level: float,
    wall_friction: float,
    axis: str = "horizontal",
    cavity: str = "box",
) -> tuple[str, ...]:
    """Return why the formula is not stated for a bed, a sentence each; empty where it is. The
    sentences hold no values, so that equal reasons of many conditions are equal.

    flow : depth of flow in grain diameters; level : a/g
    """
    reasons = (
        (axis != "horizontal", f"the axis is {axis}, and the column holds for horizontal drive"),
        (cavity != "box", f"the cavity is a {cavity}, and the column was fitted to boxes"),
        (wall_friction <= 0.0, "the walls are frictionless, and the column hangs on them"),
        (
            not _inside(bed.fill, FILLS),
            f"the fill lies outside {FILLS[0]:g} to {FILLS[1]:g}",
        ),
        (
            not _inside(level, LEVELS),
            f"the level lies outside {LEVELS[0]:g} to {LEVELS[1]:g} g",
        ),
        (
            level < TALL * (1.0 - ROUNDING) and bed.height > bed.length,
            f"the box is taller than long, and the level lies below {TALL:g} g",
        ),
        (
            flow < LEAST_FLOW,
            "the flow is shallower than one grain",
        ),
    )
    return tuple(sentence for applies, sentence in reasons if applies)


def _inside(value: float, ends: tuple[float, float]) -> bool:
    """Return whether a value lies within a range, its ends included."""
    return ends[0] * (1.0 - ROUNDING) <= value <= ends[1] * (1.0 + ROUNDING)
