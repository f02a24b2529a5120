"""Friction in a Janssen stack: eqs 1 to 5."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

SLIP_PER_DIAMETER = (4.0 * np.sqrt(3.0) / 3.0 - 2.0) / 2.0
"""Eq 4 over the diameter: the free play of a layer between its thinnest and thickest packing, about 0.1547."""


def slip_distance(diameter: float) -> float:
    """Slip of one layer from the thinnest to the thickest packing, m (eq 4; r = d/2)."""
    return SLIP_PER_DIAMETER * diameter


def janssen_length(length: float, width: float, wall_friction: float, janssen_ratio: float) -> float:
    """Depth over which the stress saturates, m: L1 L2 / (2 mu_s K_p (L1 + L2)); infinite without wall friction (eq 3)."""
    if wall_friction * janssen_ratio == 0.0:
        return float("inf")
    return length * width / (2.0 * wall_friction * janssen_ratio * (length + width))


def janssen_stress(depth: ArrayLike, bulk_density: float, gravity: float, saturation_length: float) -> Array:
    """Vertical stress at a depth below the free surface, Pa (eq 3), hydrostatic where the walls carry nothing."""
    h = np.asarray(depth, dtype=np.float64)
    if np.isinf(saturation_length):
        return bulk_density * gravity * h
    return -bulk_density * gravity * saturation_length * np.expm1(-h / saturation_length)


def friction_energy_per_slip(
    layers: int,
    diameter: float,
    length: float,
    width: float,
    bulk_density: float,
    gravity: float,
    grain_friction: float,
    saturation_length: float,
) -> float:
    """Friction work when each of the layers slips once by eq 4, J (eq 5 corrected: mu_s in the exponent, h_i = i d).

    It has no amplitude in it: the same number at any acceleration, and joules per slip, not per cycle.
    """
    depth = diameter * np.arange(1, layers + 1)
    stress = janssen_stress(depth, bulk_density, gravity, saturation_length)
    return float(grain_friction * length * width * slip_distance(diameter) * stress.sum())


def layer_capacity(
    layers: int,
    spacing: float,
    length: float,
    width: float,
    bulk_density: float,
    gravity: float,
    grain_friction: float,
    saturation_length: float,
) -> Array:
    """Net friction capacity of each layer against the box, N, shape (layers,): F_i - F_(i-1), F_i = mu_p sigma(h_i) L1 L2.

    The stack slides one way and its interfaces share the load (assumed, docs/model.md): the top layer has the
    largest capacity, the deep ones, whose weight the walls carry, the smallest.
    """
    depth = spacing * np.arange(layers + 1)
    interface = grain_friction * length * width * janssen_stress(depth, bulk_density, gravity, saturation_length)
    return np.diff(interface)


def side_wall_capacity(
    layers: int,
    spacing: float,
    length: float,
    bulk_density: float,
    gravity: float,
    wall_friction: float,
    janssen_ratio: float,
    saturation_length: float,
) -> Array:
    """Friction of each layer on the two side walls along the drive, N, shape (layers,): 2 mu_s K_p sigma L1 d.

    Implied by Janssen's own saturation, left out of the default model, offered as `side_walls: true`.
    """
    middle = spacing * (np.arange(layers) + 0.5)
    stress = janssen_stress(middle, bulk_density, gravity, saturation_length)
    return 2.0 * wall_friction * janssen_ratio * length * spacing * stress
