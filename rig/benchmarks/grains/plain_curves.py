"""Curves of the level a/g alone for the energy per cycle: what a prediction has to beat."""

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

Array = NDArray[np.float64]

Curve = Callable[[float], float]


def plain_curves(levels: Sequence[float], kappas: Sequence[float]) -> dict[str, Curve]:
    """Return curves for kappa = W/(M V^2) by name, each fitted to the same runs in ln kappa."""
    level, target = np.array(levels), np.log(kappas)
    found = {
        f"polynomial of degree {degree} in ln(a/g)": _polynomial(level, target, degree)
        for degree in range(5)
    }
    found["one Coulomb block"] = _fitted(_block, level, target)
    found["resonance in a/g"] = _fitted(_hump, level, target)
    return found


def _polynomial(level: Array, target: Array, degree: int) -> Curve:
    powers = np.polyfit(np.log(level), target, degree)
    return lambda x: math.exp(float(np.polyval(powers, math.log(x))))


def _block(p: Array, x: Array) -> Array:
    c = 1.0 / (1.0 + (x / p[1]) ** p[2]) ** (1.0 / p[2])
    return np.asarray(p[0] * c * np.sqrt(1.0 - c * c + 1e-12))


def _hump(p: Array, x: Array) -> Array:
    return np.asarray(p[0] * (x / p[1]) ** p[2] / (1.0 + (x / p[1]) ** (2.0 * p[2])))


def _fitted(curve: Callable[[Array, Array], Array], level: Array, target: Array) -> Curve:
    def residuals(p: Array) -> Array:
        return np.asarray(np.log(curve(p, level)) - target)

    bounds = ([0.01, 0.05, 0.5], [50.0, 20.0, 20.0])
    p = optimize.least_squares(residuals, [3.0, 1.0, 3.0], bounds=bounds).x  # type: ignore[operator]  # taken for a module
    return lambda x: float(curve(p, np.array(x)))
