"""Random sequential addition: put balls where no other ball is."""

import numpy as np
from numpy.typing import NDArray

from daq.compiled import njit
from rig.kernels.grains.arrays import Floats, Room


@njit(cache=True)
def place_free(
    waiting: NDArray[np.int32],
    draws: Floats,
    radii: Floats,
    room: Room,
    height: float,
    cell: float,
    slots: NDArray[np.int32],
    place: Floats,
    found: NDArray[np.bool_],
) -> None:
    """Put each waiting ball where its draw says, unless another is there."""
    nx, ny, nz, most = slots.shape
    for k in range(waiting.size):
        i = waiting[k]
        r = radii[i]
        x = r + draws[k, 0] * (room.length - 2.0 * r)
        y = r + draws[k, 1] * (room.width - 2.0 * r)
        z = r + draws[k, 2] * (height - 2.0 * r)
        if room.cylinder:
            half = 0.5 * room.length
            if (x - half) ** 2 + (y - half) ** 2 > (half - r) ** 2:
                continue
        a, b, c = int(x / cell), int(y / cell), int(z / cell)
        free = True
        for ka in range(max(a - 1, 0), min(a + 2, nx)):
            for kb in range(max(b - 1, 0), min(b + 2, ny)):
                for kc in range(max(c - 1, 0), min(c + 2, nz)):
                    for m in range(most):
                        j = slots[ka, kb, kc, m]
                        if j < 0:
                            break
                        dx, dy, dz = x - place[j, 0], y - place[j, 1], z - place[j, 2]
                        if dx * dx + dy * dy + dz * dz < (r + radii[j]) ** 2:
                            free = False
        if not free:
            continue
        for m in range(most):
            if slots[a, b, c, m] < 0:
                slots[a, b, c, m] = i
                place[i, 0], place[i, 1], place[i, 2] = x, y, z
                found[i] = True
                break
