"""Where the walls are: distance of a grain's centre from a wall, and the wall's normal."""

import math

from daq.compiled import njit
from rig.kernels.grains.arrays import (
    END_HIGH,
    END_LOW,
    FLOOR,
    LID,
    SIDE_HIGH,
    SIDE_LOW,
    Room,
)


@njit(cache=True, nogil=True)
def wall_normal(
    wall: int, x: float, y: float, z: float, room: Room
) -> tuple[float, float, float, float]:
    """Return the inward normal of a wall and the distance (m) of a point from it.

    x, y, z : the point, m, y counted from the grain's own cavity
    """
    if wall == END_LOW:
        return 1.0, 0.0, 0.0, x
    if wall == END_HIGH:
        return -1.0, 0.0, 0.0, room.length - x
    if wall == SIDE_LOW:
        return 0.0, 1.0, 0.0, y
    if wall == SIDE_HIGH:
        return 0.0, -1.0, 0.0, room.width - y
    if wall == FLOOR:
        return 0.0, 0.0, 1.0, z
    if wall == LID:
        return 0.0, 0.0, -1.0, room.height - z
    half = 0.5 * room.length
    dx, dy = half - x, half - y
    off = math.sqrt(dx * dx + dy * dy)
    if off == 0.0:
        return 1.0, 0.0, 0.0, half
    return dx / off, dy / off, 0.0, half - off
