"""What gauge and accelerometer would read on the box: their place, the gauge's own mass and the
stinger, compensated.

Phasors, h = 1, 2, ...; the box at x, the stinger's other end at x_a = x + F_st/k', k' = k + j w c.
A gauge of mass m there reads F_st + m a_a, at the box F_st, which carries m as well. An
accelerometer at that end reads a_a = a - w^2 F_st/k'. So F_st and a follow from what was read; the
force on the box itself is F_st, less m a with the gauge there.

An accelerometer away from the box sees the stinger's loss as if it were the box's: W is larger by
pi w c |F_st/k'|^2, and the apparent mass of a load M by 1/(1 - w^2 M/k). Values brought to the box
are then as uncertain as the stiffness.
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
    """A run compensated with what the laboratory knows: ends ("box" or "exciter") of force gauge
    and accelerometer, the gauge's mass (kg), and the stinger in the exciter's document. What does
    not repeat from cycle to cycle stays as read.
    """
    jw: Complex = (
        2j * math.pi * energy.frequency * np.arange(1, energy.force.size + 1).astype(np.complex128)
    )
    stiffness, loss = float(exciter.stinger_stiffness), jw * float(exciter.stinger_damping)
    places = gauge, accelerometer, mass, jw
    on_box, acceleration = _on_box(energy, *places, stiffness + loss)
    stiffer = _on_box(energy, *places, stiffness * (1 + float(exciter.parts_U) / 2) + loss)
    frequency, M = energy.frequency, _mass(on_box, acceleration)
    moved = _work(on_box, acceleration, jw, frequency) - _work(
        energy.force, energy.acceleration, jw, frequency
    )
    return AtBox(energy.W + moved, M, abs(complex(acceleration[0])), _mass(*stiffer) - M)


def _on_box(
    energy: Energy, gauge: str, accelerometer: str, mass: float, jw: Complex, stinger: Complex
) -> tuple[Complex, Complex]:
    """Force on the box without the gauge's mass (N) and its acceleration (m/s^2), from what was
    read beside a stinger of that complex stiffness (N/m)."""
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
    """Apparent mass at the fundamental, kg; nan without motion."""
    first, a = complex(force[0]), complex(acceleration[0])
    return (first * a.conjugate()).real / abs(a) ** 2 if a else math.nan


def _work(force: Complex, acceleration: Complex, jw: Complex, frequency: float) -> float:
    """Closed-loop integral of F v dt, J per cycle."""
    return -0.5 / frequency * float(((force * acceleration.conj()).imag / jw.imag).sum())
