"""Arrays handed on uncounted: the same numbers at the same place, and the owner's count untouched."""

import sys

import numpy as np
from numba import njit

from rig.kernels.borrowed import borrowed


@njit
def _through(x: np.ndarray, times: int) -> float:
    view = borrowed(x)
    total = 0.0
    for k in range(times):
        row = view[k % view.shape[0]]
        row[0] += 1.0
        total += row.sum()
    return total


def test_a_borrowed_array_is_the_same_array() -> None:
    x = np.arange(12.0).reshape(3, 4)
    whole = x.sum()
    count = sys.getrefcount(x)
    assert _through(x, 3) == whole + 3.0
    assert x[:, 0].tolist() == [1.0, 5.0, 9.0]
    _through(x, 1000)
    assert sys.getrefcount(x) == count


def test_a_borrowed_strided_view_keeps_its_strides() -> None:
    x = np.arange(12.0).reshape(3, 4)
    assert _through(x[:, ::2], 1) == 0.0 + 1.0 + 2.0
    assert x[0, 0] == 1.0
