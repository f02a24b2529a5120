"""Friction in a Janssen stack: eqs 1 to 5."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

SLIP_PER_DIAMETER = float((4.0 * np.sqrt(3.0) / 3.0 - 2.0) / 2.0)
"""Eq 4 divided by the diameter: the clearance of a layer between its thinnest and thickest packing,
about 0.1547.
"""


class SliceForces(NamedTuple):
    """Vertical forces on a slice of the stack, N.

    F1, F2 : wall friction, one wall of length L1, one of L2
    F3 : from below; F4 : from above
    G : weight
    """

    F1: float
    F2: float
    F3: float
    F4: float
    G: float


def slice_forces(
    stress: float,
    stress_step: float,
    thickness: float,
    length: float,
    width: float,
    bulk_density: float,
    gravity: float,
    wall_friction: float,
    janssen_ratio: float,
) -> SliceForces:
    """Return the forces on a slice of `thickness` (m) under `stress` (Pa), which grows by
    `stress_step` through it, N (eq 2).

    Right as printed, for wall friction fully mobilised upward: a silo at rest, which a shaken bed
    is not.
    """
    side = wall_friction * janssen_ratio * stress * thickness
    area = length * width
    return SliceForces(
        F1=side * length,
        F2=side * width,
        F3=(stress + stress_step) * area,
        F4=stress * area,
        G=bulk_density * gravity * area * thickness,
    )


def slice_imbalance(forces: SliceForces) -> float:
    """Return 2 F1 + 2 F2 + F3 - F4 - G, N: upward minus downward, zero for a slice at rest (eq 1,
    right as printed).
    """
    return 2.0 * forces.F1 + 2.0 * forces.F2 + forces.F3 - forces.F4 - forces.G


def slip_distance(diameter: float) -> float:
    """Return the slip of one layer, m (eq 4; r = d/2): (4 sqrt(3)/3 - 2) r = 0.3094 r.

    Erratum: this is the free gap along the edge of a body-centred cell (edge 4 r/sqrt(3)), one
    choice of geometry among several, and not "from the thinnest to the thickest".
    """
    return SLIP_PER_DIAMETER * diameter


def janssen_length(
    length: float, width: float, wall_friction: float, janssen_ratio: float
) -> float:
    """Return the depth over which the stress saturates, m (eq 3): L1 L2/(2 mu_s K_p (L1 + L2)).

    Infinite without wall friction.
    """
    if wall_friction * janssen_ratio == 0.0:
        return float("inf")
    return length * width / (2.0 * wall_friction * janssen_ratio * (length + width))


def janssen_stress(
    depth: ArrayLike, bulk_density: float, gravity: float, saturation_length: float
) -> Array:
    """Return the vertical stress at a depth below the free surface, Pa (eq 3); hydrostatic if the
    walls carry nothing.

    Right as printed. Eq 3 does not contain the fill rate; a depth measured from the *lid* brings it
    in (Fig. 6).
    """
    h = np.asarray(depth, dtype=np.float64)
    if np.isinf(saturation_length):
        return bulk_density * gravity * h
    # Not numpy's expm1: its last digit depends on the processor, and the paths of rows without a
    # period diverge from a difference in the last digit.
    shortfall = np.vectorize(math.expm1, otypes=[np.float64])(-h / saturation_length)
    return np.asarray(-bulk_density * gravity * saturation_length * shortfall)


def friction_energy_per_slip(
    layers: int,
    diameter: float,
    length: float,
    width: float,
    bulk_density: float,
    gravity: float,
    grain_friction: ArrayLike,
    saturation_length: float,
) -> float:
    """Return the friction work of one slip of every layer by eq 4, J (eq 5 corrected: mu_s in the
    exponent, h_i = i d).

    grain_friction : mu_p of every layer, shape (layers,), or one for all

    Errata: the exponent has mu_i instead of mu_s; h_i = w H would put every layer at the bottom; N
    must be an integer.
    The result does not depend on the amplitude: it is the same at any acceleration, in joules per
    slip, not per cycle.
    """
    # Erratum of eq 5: the lower interface of layer i lies at h_i = i d.
    depth = diameter * np.arange(1, layers + 1)
    stress = janssen_stress(depth, bulk_density, gravity, saturation_length)
    capacity = np.asarray(grain_friction, dtype=np.float64) * stress
    return float(length * width * slip_distance(diameter) * capacity.sum())


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
    """Return the net friction capacity of each layer against the box, N, shape (layers,).

    F_i - F_(i-1), where F_i = mu_p sigma(h_i) L1 L2 is the capacity of the interface below layer i.
    The stack slides one way and its interfaces share the load (assumed, docs/model.md): the top
    layer has the largest capacity; the deep ones, whose weight the walls carry, have the smallest.
    """
    depth = spacing * np.arange(layers + 1)
    interface = (
        grain_friction
        * length
        * width
        * janssen_stress(depth, bulk_density, gravity, saturation_length)
    )
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
    """Return the friction of each layer on the two side walls along the drive, N, shape (layers,):
    2 mu_s K_p sigma L1 d.

    Implied by Janssen's own saturation, absent from the default model, available as `side_walls:
    true`.
    """
    # Stress at mid-height of each layer.
    middle = spacing * (np.arange(layers) + 0.5)
    stress = janssen_stress(middle, bulk_density, gravity, saturation_length)
    return 2.0 * wall_friction * janssen_ratio * length * spacing * stress
