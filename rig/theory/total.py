"""W_T = W_f + W_c (eq 24): the model as printed (variant as printed, with errata) and event-resolved
(layers variant).

The event-resolved one is for comparison with measurements.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rig.kernels.rows.many_rows import LONGEST_SPAN, steady_and_window, steady_energy
from rig.kernels.rows.one_row import MAX_EVENTS, RowSet
from rig.kernels.waveform import crossings, extrema
from rig.theory.chain import first_grain_velocity, first_wave_loss, wall_loss

Array = NDArray[np.float64]

AVERAGED_CYCLES = 448
"""Cycles over which a row without a period is averaged.

Some rows wander for hundreds of cycles before they become periodic: 64 cycles were up to 0.4 % of
W_T off, 448 are within 0.02 % of 4096 on the shipped protocols (tests/physics/test_rows.py).
"""


@dataclass(frozen=True)
class ModelEnergy:
    """Energy per cycle of the event-resolved model (layers variant), J.

    period : longest period of a sliding row in cycles of the drive, 0 if any row has none
    periodic_share : fraction of W_T in rows that have a period
    window : mean over the requested cycles, counted from the start of the motion; None if none were
        requested
    """

    friction: float
    collision: float
    period: int
    periodic_share: float
    window: float | None = None

    @property
    def total(self) -> float:
        """W_T = W_f + W_c, J (eq 24)."""
        return self.friction + self.collision


class TooManyEvents(ArithmeticError):
    """A row with more events in one cycle, or more cycles to cross its clearance, than can
    be followed.
    """


def as_printed_collision(
    layer_mass: float,
    grains: int,
    restitution: float,
    restitution_wall: float,
    wall_velocity: float,
) -> float:
    """Return W_c of the model as printed, J per cycle: one layer of chains per struck wall, two
    walls per cycle (eqs 20 to 23).

    `layer_mass` is the mass of the layer of first grains, rho_b L2 w H d; each chain has n =
    floor(L1/d) grains.
    """
    first = first_grain_velocity(wall_velocity, restitution_wall)
    wave = first_wave_loss(np.full(grains, layer_mass), restitution, first)
    return 2.0 * (wall_loss(layer_mass, restitution_wall, wall_velocity) + wave)


def plastic_bound(mass: float, velocity: float, row_restitution: float) -> float:
    """Return the upper bound of the energy that a bed between two walls dissipates per cycle, J.

    4 M V^2 (1 + e_row)/(1 - e_row); infinite for e_row = 1.
    """
    if row_restitution >= 1.0:
        return float("inf")
    return 4.0 * mass * velocity**2 * (1.0 + row_restitution) / (1.0 - row_restitution)


def slider_bound(mass: float, velocity: float) -> float:
    """Return the upper bound of the energy that blocks with Coulomb friction and no walls dissipate
    per cycle of a sine, J: 4/pi M V^2.

    Largest value of 4 eta sqrt(1 - (pi eta/2)^2), eta the threshold over the peak acceleration.
    """
    return 4.0 / np.pi * mass * velocity**2


def sliding_rows(
    threshold: Array,
    clearance: Array,
    row_restitution: float,
    acceleration: float,
    frequency: float,
) -> RowSet:
    """Return the rows that slide on an exact sine of peak `acceleration`, in units of that sine.

    threshold : acceleration at which each layer slides, m/s^2, shape (layers,)
    clearance : clearance of each row, m, shape (layers, rows); infinite for rows without end walls
    """
    sine, cosine = np.ones(1), np.zeros(1)
    flowing = threshold < acceleration
    band = threshold[flowing] / acceleration
    # Lengths in units of the waveform, A/w^2; accelerations in units of A.
    free = (clearance[flowing] * ((2.0 * np.pi * frequency) ** 2 / acceleration)).ravel()
    layer = np.repeat(np.arange(band.size), clearance.shape[1])
    return RowSet(
        layer,
        free,
        row_restitution,
        band,
        crossings(band, sine, cosine, extrema(sine, cosine)).tables,
    )


def layer_energies(
    threshold: Array,
    clearance: Array,
    row_mass: float,
    row_restitution: float,
    acceleration: float,
    frequency: float,
    averaged_cycles: int,
) -> Array:
    """Return the energy per cycle of each row, J, shape (layers, rows); arguments as for
    `layers_total`. Raises TooManyEvents.
    """
    energy = np.zeros(clearance.shape)
    rows = sliding_rows(threshold, clearance, row_restitution, acceleration, frequency)
    if rows.clearance.size:
        friction, collision, period = steady_energy(rows, np.ones(1), np.zeros(1), averaged_cycles)
        _refuse(period)
        # Kernel energies are per mass in units of the squared velocity amplitude (A/w)^2.
        unit = row_mass * (acceleration / (2.0 * np.pi * frequency)) ** 2
        # Layers below their threshold ride and keep 0.
        energy[threshold < acceleration] = unit * (friction + collision).reshape(
            -1, clearance.shape[1]
        )
    return energy


def _refuse(period: NDArray[np.int64]) -> None:
    """Raise TooManyEvents if a row could not be followed; the kernel reports the reason as a
    negative period.
    """
    if (period == -1).any():
        raise TooManyEvents(f"meets more than {MAX_EVENTS} events in one cycle")
    if (period == -2).any():
        raise TooManyEvents(f"takes more than {LONGEST_SPAN} cycles to cross its clearance")


def layers_total(
    threshold: Array,
    clearance: Array,
    row_mass: float,
    row_restitution: float,
    acceleration: float,
    frequency: float,
    averaged_cycles: int = AVERAGED_CYCLES,
    window: tuple[int, int] | None = None,
) -> ModelEnergy:
    """Return the energy per cycle of independent rows on an exact sine, in their steady state
    (layers variant).

    threshold : acceleration at which each layer slides, m/s^2, shape (layers,)
    clearance : clearance of each row, m, shape (layers, rows)
    row_mass : kg; acceleration : peak of the sine, m/s^2; frequency : Hz
    averaged_cycles : cycles over which rows without a period are averaged
    window : (first cycle, one past the last) of an additional mean; None for none

    Raises TooManyEvents.
    """
    rows = sliding_rows(threshold, clearance, row_restitution, acceleration, frequency)
    if rows.clearance.size == 0:
        return ModelEnergy(0.0, 0.0, 1, 1.0, None if window is None else 0.0)
    friction, collision, period, seen = steady_and_window(
        rows, np.ones(1), np.zeros(1), averaged_cycles, window or (0, 0)
    )
    _refuse(period)
    unit = row_mass * (acceleration / (2.0 * np.pi * frequency)) ** 2
    each = friction + collision
    taken = float(each.sum())
    return ModelEnergy(
        friction=float(unit * friction.sum()),
        collision=float(unit * collision.sum()),
        period=int(period.max()) if (period > 0).all() else 0,
        periodic_share=float(each[period > 0].sum()) / taken
        if taken > 0.0
        else float((period > 0).all()),
        window=None if window is None else float(unit * seen.sum()),
    )
