"""Energies of a window of whole cycles, with the phasors that they are computed from."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

__all__ = ["AtBox", "Energy"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Energy:
    """Energies of a window, J per cycle, and phasors (peak values, t = 0 at the window's start).

    frequency : of the drive, Hz
    W : loop estimator, mean over the cycles
    W_cycles : the same of each cycle, (cycles,)
    W_exc : integral of F v dt over the whole window
    W_kin : change of the box's kinetic energy per cycle, from the first cycle start to the last; 0
        without a box mass
    W_phasor : phasor estimator
    force, acceleration : phasors of harmonics 1, 2, ..., N and m/s^2
    """

    frequency: float
    cycles: int
    W: float
    W_cycles: Array
    W_exc: float
    W_kin: float
    W_phasor: float
    force: Complex
    acceleration: Complex

    @property
    def W_eq25(self) -> float:
        """Eq. 25: excitation energy less the change of the box's kinetic energy, J per cycle."""
        return self.W_exc - self.W_kin

    @cached_property
    def level(self) -> float:
        """Amplitude of the fundamental acceleration, m/s^2."""
        return abs(complex(self.acceleration[0]))

    @cached_property
    def M_eff(self) -> float:
        """Apparent mass at the fundamental, kg: real part of F/A of everything beyond the gauge
        plane.
        """
        force, acceleration = complex(self.force[0]), complex(self.acceleration[0])
        return (
            (force * acceleration.conjugate()).real / abs(acceleration) ** 2
            if acceleration
            else math.nan
        )

    @cached_property
    def reactive(self) -> float:
        """(pi / w^2) M_eff a^2 in J: the error of W per radian of phase error."""
        return math.pi * self.M_eff * (self.level / (2 * math.pi * self.frequency)) ** 2

    @cached_property
    def eta(self) -> float:
        """Loss factor W w^2 / (pi M_eff a^2); nan without motion or apparent mass."""
        return self.W / self.reactive if self.reactive else math.nan

    @property
    def thd_force(self) -> float:
        """Harmonic distortion of the force: rms of harmonics 2 and up over the fundamental's."""
        first = abs(complex(self.force[0]))
        return float(np.linalg.norm(self.force[1:])) / first if first else math.nan

    @property
    def force_level(self) -> float:
        """Amplitude of the fundamental force, N."""
        return abs(complex(self.force[0]))

    @property
    def force_phase(self) -> float:
        """Angle by which the fundamental force leads the acceleration, rad; nan without motion."""
        ratio = complex(self.force[0]) * complex(self.acceleration[0]).conjugate()
        return float(np.angle(ratio)) if ratio else math.nan

    @property
    def thd_acceleration(self) -> float:
        """Harmonic distortion of the acceleration: rms of harmonics 2 and up over the
        fundamental's.
        """
        return float(np.linalg.norm(self.acceleration[1:])) / self.level if self.level else math.nan


@dataclass(frozen=True, slots=True)
class AtBox:
    """A run corrected to the box: without the stinger and the gauge's mass.

    W : energy into the box, J per cycle
    M_eff : apparent mass of the box and its content, kg
    level : fundamental acceleration of the box, m/s^2
    M_stiffness : change of M_eff per standard deviation of the stinger's stiffness, kg, with its
        sign
    """

    W: float
    M_eff: float
    level: float
    M_stiffness: float
