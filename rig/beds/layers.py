"""Beds `layers` and `column` in prescribed motion: every row exact between events, periodic rows replayed from
their stored period.
"""

from dataclasses import dataclass

import numpy as np

from rig.beds.bed import Array, Reaction
from rig.beds.janssen_stack import Stack
from rig.drive.waveform import Sampling
from rig.errors import InputError, Mistake
from rig.kernels.rows.many_rows import MEMORY, EdgeGrid, follow
from rig.kernels.rows.one_row import MAX_EVENTS, RowSet
from rig.kernels.waveform import crossings, extrema


class LayersBed:
    """The rows of a stack in a box that follows a waveform; rows start at rest at x = 0, where the
    end wall is unless their clearance is infinite.

    Layers whose threshold the waveform never reaches ride as mass and are not simulated.
    """

    def __init__(self, stack: Stack, sampling: Sampling) -> None:
        motion = sampling.motion
        self._sampling = sampling
        self._cycles = 0
        self._stack = stack
        self._coefficients = motion.coefficients
        band = stack.threshold / motion.acceleration
        found = crossings(band, *self._coefficients, extrema(*self._coefficients))
        flowing = np.flatnonzero(found.counts)
        clearance = stack.clearance[flowing] / motion.length_unit
        self._rows = RowSet(
            np.repeat(flowing, clearance.shape[1]),
            clearance.ravel(),
            stack.restitution,
            band,
            found.tables,
        )
        self._memory = np.zeros(clearance.size, MEMORY)
        self._riding_mass = stack.mass - stack.row_mass * clearance.size
        self._velocity = _Velocity(np.zeros(0), np.zeros(0))

    @property
    def mass(self) -> float:
        """Mass of the grains, kg."""
        return self._stack.mass

    @property
    def kinetic_at_start(self) -> float:
        """Kinetic energy of the bed when the motion starts, J: all of it rides with the box."""
        return 0.5 * self.mass * self._sampling.motion.start_velocity**2

    def advance(self, cycles: int) -> Reaction:
        """Advance by whole cycles of the drive. Raises InputError if a row has too many events to
        follow.
        """
        motion, mass = self._sampling.motion, self._stack.row_mass
        unit = motion.velocity_unit
        velocity = self._sampling.edges(self._cycles, cycles).velocity
        # A sampling that repeats returns the same object: its scaled copy is made once.
        # A sampling that repeats returns the same object: its scaled copy is made once.
        if self._velocity.box is not velocity:
            self._velocity = _Velocity(velocity, velocity[1:] / unit)
        momentum, ledger, repeats = follow(
            EdgeGrid(self._cycles, cycles, float(self._sampling.edges_per_cycle)),
            self._velocity.scaled,
            self._riding_mass / mass if mass else 0.0,
            mass * unit,
            self._rows,
            *self._coefficients,
            self._memory,
        )
        if repeats < 0:
            raise cannot_follow(self._stack, f"meets more than {MAX_EVENTS} events in one cycle")
        self._cycles += cycles
        energy: Array = mass * unit**2 * ledger
        return Reaction(
            momentum=momentum,
            work=energy[:, 0],
            friction=energy[:, 1],
            collision=energy[:, 2],
            viscous=np.zeros(cycles),
            kinetic=energy[:, 3] + 0.5 * self._riding_mass * motion.start_velocity**2,
            repeats=repeats,
        )


@dataclass(frozen=True)
class _Velocity:
    """Box velocity at the sampling edges.

    box : m/s, with the edge before the first
    scaled : in units of the waveform, without that edge
    """

    box: Array
    scaled: Array


def cannot_follow(stack: Stack, what: str) -> InputError:
    """Return the error for rows that cannot be followed; `what` completes the sentence "one row
    ...".
    """
    return InputError(
        Mistake(
            where="scene",
            field="scene.layers.clearance",
            found=f"rows with {stack.clearance.min():.3g} m of clearance or more and restitution {stack.restitution:.3g}: "
            f"one {what}",
            allowed="a clearance nearer to the amplitude, friction, or rows that rebound less",
        )
    )
