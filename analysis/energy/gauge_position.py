"""Correction of gauge and accelerometer readings to the box: positions, mass of the gauge, stinger.

Phasors, h = 1, 2, ...; box at x, far end of the stinger at x_a = x + F_st/k', k' = k + j w c. A
gauge of mass m at the far end reads F_st + m a_a. A gauge at the box reads F_st, which also
accelerates the gauge. An accelerometer at the far end reads a_a = a - w^2 F_st/k'. F_st and a
follow from the readings; the force on the box is F_st, less m a if the gauge is there.

An accelerometer away from the box attributes the loss of the stinger to the box: W is larger by pi
w c |F_st/k'|^2, and the apparent mass of a load M by the factor 1/(1 - w^2 M/k). Corrected values
are therefore as uncertain as the stiffness.
"""

import math

import numpy as np
from numpy.typing import NDArray

from analysis.energy.energy_and_phasors import AtBox, Energy
from analysis.session.exciter import SessionExciter

__all__ = ["at_box"]

Complex = NDArray[np.complex128]


def at_box(
    energy: Energy, gauge: str, accelerometer: str, mass: float, exciter: SessionExciter
) -> AtBox:
    """Return a run corrected to the box.

    gauge, accelerometer: the end of the stinger ("box" or "exciter") where each is fixed; mass: of
    the gauge, kg; exciter: the session's document, with the stinger. Parts of the signals that do
    not repeat from cycle to cycle are left as read.
    """
    jw: Complex = (
        2j * math.pi * energy.frequency * np.arange(1, energy.force.size + 1).astype(np.complex128)
    )
    stiffness, loss = float(exciter.stinger_stiffness), jw * float(exciter.stinger_damping)
    places = gauge, accelerometer, mass, jw
    on_box, acceleration = _on_box(energy, *places, stiffness + loss)
    # parts_U is an expanded uncertainty (k = 2): half of it is one standard deviation.
    stiffer = _on_box(energy, *places, stiffness * (1 + float(exciter.parts_U) / 2) + loss)
    frequency, M = energy.frequency, _mass(on_box, acceleration)
    moved = _work(on_box, acceleration, jw, frequency) - _work(
        energy.force, energy.acceleration, jw, frequency
    )
    return AtBox(energy.W + moved, M, abs(complex(acceleration[0])), _mass(*stiffer) - M)


def _on_box(
    energy: Energy, gauge: str, accelerometer: str, mass: float, jw: Complex, stinger: Complex
) -> tuple[Complex, Complex]:
    """Return the force on the box without the gauge's mass (N) and the box's acceleration (m/s^2).

    stinger: complex stiffness of the stinger, N/m, (harmonics,).
    """
    force, read = energy.force, energy.acceleration
    if accelerometer == "exciter":
        pull = force - mass * read if gauge == "exciter" else force
        acceleration = read - jw**2 * pull / stinger
    else:
        acceleration = read
        pull = (
            (force - mass * read) / (1.0 + mass * jw**2 / stinger) if gauge == "exciter" else force
        )
    return pull - mass * acceleration if gauge == "box" else pull, acceleration


def _mass(force: Complex, acceleration: Complex) -> float:
    """Return the apparent mass at the fundamental, kg; nan without motion."""
    first, a = complex(force[0]), complex(acceleration[0])
    return (first * a.conjugate()).real / abs(a) ** 2 if a else math.nan


def _work(force: Complex, acceleration: Complex, jw: Complex, frequency: float) -> float:
    """Return the closed integral of F v dt, J per cycle."""
    return -0.5 / frequency * float(((force * acceleration.conj()).imag / jw.imag).sum())
