"""Drag of the air inside the bed: Ergun's law on the slip of the rows, as a perturbation that does
not affect their motion.

The air moves with the closed box, so a row that slips at speed U drags its volume through still
air: dp/L = 150 mu (1 - eps)^2 U/(eps^3 d^2) + 1.75 rho (1 - eps) U^2/(eps^3 d), eps the void
fraction (Ergun 1952). The dissipated energy is the power dp/L U integrated over time and volume. At
the gauge it appears as the viscous force that takes the same energy from the box: its magnitude is
right, its phase within the cycle is not.
"""

from functools import lru_cache

import numpy as np

from rig.beds.column import rows_of
from rig.beds.janssen_stack import Filling, Stack, nominal
from rig.catalog.entries import Rig
from rig.drive.losses import AIR_DENSITY, AIR_VISCOSITY
from rig.drive.waveform import Waveform, viscous_energy
from rig.kernels.rows.one_row import RowSet
from rig.kernels.rows.slip_moments import slip_moments
from rig.kernels.waveform import crossings, extrema
from rig.protocol.spec import BEDS_OF_ROWS, Scene

LEAST_SHARE = 0.01
"""Gas drag below this fraction of the bed's weight, at the fastest slip, is neglected."""


def ergun(diameter: float, packing: float) -> tuple[float, float]:
    """Return the coefficients of U and U^2 in the pressure gradient through a bed at rest, Pa s/m^2
    and Pa s^2/m^3.
    """
    void = 1.0 - packing
    viscous = 150.0 * AIR_VISCOSITY * packing**2 / (void**3 * diameter**2)
    inertial = 1.75 * AIR_DENSITY * packing / (void**3 * diameter)
    return viscous, inertial


@lru_cache(maxsize=1024)
def share_of_weight(scene: Scene, rig: Rig, acceleration: float, frequency: float) -> float:
    """Return the ratio of the largest gas drag to the weight, per volume of the bed: nominal
    filling, exact sine; 0 without slip.
    """
    density = scene.grains.density
    if scene.bed not in BEDS_OF_ROWS or density is None:
        return 0.0
    motion = Waveform(frequency, acceleration)
    filling = nominal(scene, rig)
    peak = motion.velocity_unit * _moments(rows_of(scene, rig, filling), motion)[2]
    viscous, inertial = ergun(scene.grains.diameter, filling.packing)
    return (viscous * peak + inertial * peak**2) / (filling.packing * density * rig.gravity)


def gas_energy(scene: Scene, rig: Rig, filling: Filling, motion: Waveform) -> float:
    """Return the energy that the air in the voids takes from one filling per cycle of a
    motion, J.
    """
    density = scene.grains.density
    if scene.bed not in BEDS_OF_ROWS or density is None:
        return 0.0
    bed = rows_of(scene, rig, filling)
    second, third, _ = _moments(bed, motion)
    viscous, inertial = ergun(scene.grains.diameter, filling.packing)
    unit = motion.velocity_unit
    volume = bed.row_mass / (filling.packing * density)
    return volume * unit**2 / motion.omega * (viscous * second + inertial * unit * third)


def gas_damping(scene: Scene, rig: Rig, filling: Filling, motion: Waveform) -> float:
    """Return the viscous coefficient at the gauge that takes the same energy, N s/m; 0 below
    `LEAST_SHARE` of the weight.
    """
    if share_of_weight(scene, rig, motion.acceleration, motion.frequency) <= LEAST_SHARE:
        return 0.0
    return gas_energy(scene, rig, filling, motion) / viscous_energy(1.0, motion)


def _moments(bed: Stack, motion: Waveform) -> tuple[float, float, float]:
    """Return the slip moments of the sliding rows (rig.kernels.rows.slip_moments), in units of the
    motion.
    """
    P, Q = motion.coefficients
    band = bed.threshold / motion.acceleration
    found = crossings(band, P, Q, extrema(P, Q))
    flowing = np.flatnonzero(found.counts)
    clearance = bed.clearance[flowing] / motion.length_unit
    if clearance.size == 0:
        return 0.0, 0.0, 0.0
    rows = RowSet(
        np.repeat(flowing, clearance.shape[1]),
        clearance.ravel(),
        bed.restitution,
        band,
        found.tables,
    )
    return slip_moments(rows, P, Q)
