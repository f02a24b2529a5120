"""Coefficients of the column over the friction of grains and walls, from a table shipped with the
package.
"""

import csv
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from rig.theory.column import ColumnCoefficients, YieldProfile

Array = NDArray[np.float64]

VALUES = ("mu0", "dK", "mu_w_K", "q")
ROUNDING = 1e-9
"""Distance from the edge of the table within which a friction is at the edge."""


class OutsideTable(ValueError):
    """The friction lies outside the table; the message is the reason."""


@dataclass(frozen=True, eq=False)
class FrictionTable:
    """Values on a rectangular grid of friction coefficients.

    mu_p : of grain on grain, increasing, shape (m,); mu_w : of grain on wall, increasing, shape (n,)
    values : in the order of `VALUES`, shape (m, n, 4)
    """

    mu_p: Array
    mu_w: Array
    values: Array

    @classmethod
    def of(cls, rows: Iterable[Sequence[float]]) -> "FrictionTable":
        """Return the table of rows (mu_p, mu_w, mu0, dK, mu_w_K, q) in any order.

        Raises ValueError unless they fill a rectangular grid, each pair once.
        """
        given = list(rows)
        found = {(row[0], row[1]): row[2:] for row in given}
        mu_p, mu_w = (sorted({pair[k] for pair in found}) for k in (0, 1))
        if not found or len(given) != len(mu_p) * len(mu_w) or len(found) != len(given):
            raise ValueError("the pairs mu_p, mu_w must fill a rectangular grid, each pair once")
        values = np.array([[found[p, w] for w in mu_w] for p in mu_p], dtype=np.float64)
        return cls(np.array(mu_p), np.array(mu_w), values)

    def at(self, mu_p: float, mu_w: float) -> Array:
        """Return the values at a pair of friction coefficients, bilinear between the grid's, shape
        (4,). Raises OutsideTable.
        """
        along_p = _weights(self.mu_p, mu_p, "mu_p of grain on grain")
        along_w = _weights(self.mu_w, mu_w, "mu_w of grain on wall")
        return np.asarray(along_p @ np.tensordot(self.values, along_w, ([1], [0])))


def _weights(grid: Array, value: float, name: str) -> Array:
    """Return the weight of each point of a grid in a linear interpolation. Raises OutsideTable."""
    if not grid[0] - ROUNDING <= value <= grid[-1] + ROUNDING:
        known = f"{grid[0]:g}" if grid.size == 1 else f"{grid[0]:g} to {grid[-1]:g}"
        raise OutsideTable(
            f"the friction coefficient {name} is {value:g}, and the table has {known}"
        )
    return np.array([np.interp(value, grid, row) for row in np.eye(grid.size)])


@cache
def shipped(form: str) -> FrictionTable:
    """Return the table of a form, `formula` or `blocks`, that the package ships."""
    text = files("rig.theory").joinpath("column_table.csv").read_text(encoding="utf-8")
    lines = (line for line in text.splitlines() if not line.startswith("#"))
    return FrictionTable.of(
        [
            (float(row["mu_p"]), float(row["mu_w"]), *(float(row[n] or math.nan) for n in VALUES))
            for row in csv.DictReader(lines)
            if row["form"] == form
        ]
    )


def column_coefficients(mu_p: float, mu_w: float) -> ColumnCoefficients:
    """Return the formula's coefficients at the friction of grains and walls. Raises OutsideTable."""
    mu0, dK, mu_w_K, q = (float(value) for value in shipped("formula").at(mu_p, mu_w))
    return ColumnCoefficients(YieldProfile(mu0, dK, mu_w_K), q)


def block_profile(mu_p: float, mu_w: float) -> YieldProfile:
    """Return the thresholds of Coulomb blocks (bed `column`) at the friction of grains and walls.
    Raises OutsideTable.
    """
    mu0, dK, mu_w_K, _ = (float(value) for value in shipped("blocks").at(mu_p, mu_w))
    return YieldProfile(mu0, dK, mu_w_K)
