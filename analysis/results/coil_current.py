"""W_coil: an independent estimate of the dissipated energy from the exciter's coil current, without
the force gauge.

The coil's force BL i drives armature, flexure, body and stinger besides the box. With the exciter
known, the force at the gauge plane follows from current and box acceleration, harmonic by harmonic;
its work on the box is W_coil. Tare of the flexure, recoil of the body and stretch of the stinger
are included. Not included are harmonics above the band in which the current determines the force
(half the resonance of the armature on its stinger), and nonlinear effects.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.energy.energy_and_phasors import Energy
from analysis.results.run import Coil
from analysis.session.exciter import SessionExciter
from analysis.session.record import ChannelFacts
from analysis.uncertainty.budget import CERTIFICATE_NU, combine, scatter_line, stretch_of
from analysis.uncertainty.budget_line import Line
from analysis.uncertainty.estimate import Estimate

__all__ = ["coil_estimates", "coil_force", "coil_of"]

Complex = NDArray[np.complex128]

PARTS = (
    "moving_mass", "flexure_stiffness", "flexure_damping_ratio", "body_mass", "isolation_stiffness",
    "isolation_damping_ratio", "stinger_stiffness", "stinger_damping",
)  # fmt: skip
STEP = 1e-4  # relative step of the central differences that give sensitivities


def coil_force(
    current: Complex, acceleration: Complex, frequency: float, exciter: SessionExciter
) -> Complex:
    """Return the force phasors at the gauge plane (N) from phasors of coil current (A) and box
    acceleration (m/s^2).

    Harmonics 1, 2, ... of `frequency` (Hz). The exciter's equations, solved for F: m_a x_a'' + c_s
    (x_a' - x_b') + k_s (x_a - x_b) + F = BL i, m_b x_b'' + isolation - (..)_s = -BL i, F = (k_st +
    j w c_st) (x_a - x).
    """
    jw = 2j * np.pi * frequency * np.arange(1, current.size + 1)

    def spring(k: float, damping_ratio: float, m: float) -> Complex:
        return np.asarray(k + jw * (2 * damping_ratio * math.sqrt(k * m)))

    flexure = spring(exciter.flexure_stiffness, exciter.flexure_damping_ratio, exciter.moving_mass)
    isolation = spring(
        exciter.isolation_stiffness, exciter.isolation_damping_ratio, exciter.body_mass
    )
    body = exciter.body_mass * jw**2 + isolation + flexure
    stinger = exciter.stinger_stiffness + jw * exciter.stinger_damping
    thrust = exciter.force_constant * current * (1 - flexure / body)
    carried = exciter.moving_mass * jw**2 + flexure - flexure**2 / body
    return np.asarray((thrust - carried * acceleration / jw**2) / (1 + carried / stinger))


def coil_of(
    current: Complex, energy: Energy, channel: ChannelFacts, exciter: SessionExciter, samples: int
) -> Coil:
    """Return W_coil of a run with its budget.

    current: phasors, A; energy: of the run; exciter: the session's document, certified values and
    their U; samples: number of samples in the window.
    """
    orders = min(current.size, int(exciter.band / energy.frequency))
    i, A = current[:orders], energy.acceleration[:orders]
    frequency = energy.frequency

    def W(known: SessionExciter, scale: float = 1.0) -> float:
        return _work(coil_force(scale * i, A, frequency, known), A, frequency)

    def slope(changed: Callable[[float], float]) -> float:
        return (changed(1 + STEP) - changed(1 - STEP)) / (2 * STEP)

    per_current = slope(lambda factor: W(exciter, factor))
    # The gauge serves for one purpose only: to bound the energy of harmonics above the band.
    above = abs(_work(energy.force[orders:], energy.acceleration[orders:], frequency, orders + 1))
    constant_U, parts_U = exciter.force_constant_U, exciter.parts_U
    lines = [
        Line("current sensitivity", "1", channel.calibration_U / 2, CERTIFICATE_NU, per_current),
        Line("current gain", "1", channel.gain_tolerance / math.sqrt(3), math.inf, per_current),
        Line("force constant", "1", constant_U / 2, CERTIFICATE_NU, per_current),
        *(
            Line(
                name.replace("_", " "),
                "1",
                parts_U / 2,
                CERTIFICATE_NU,
                slope(lambda factor, name=name: W(_scaled(exciter, name, factor))),  # type: ignore[misc]
            )
            for name in PARTS
        ),
        Line("above the coil's band", "J", above / math.sqrt(3), math.inf, 1.0),
    ]
    # A quadrature of a phasor over N samples has sigma sqrt(2/N) rms; W = (pi/w^2) F a sin(phase).
    noise = exciter.force_constant * channel.noise_rms * energy.level / (4 * math.pi * frequency**2)
    return Coil(
        W(exciter), tuple(line for line in lines if line.u > 0), noise * math.sqrt(2 / samples)
    )


def _scaled(exciter: SessionExciter, part: str, factor: float) -> SessionExciter:
    """Return the exciter with one of its values multiplied by a factor."""
    changed: dict[str, float] = {part: getattr(exciter, part) * factor}
    return replace(exciter, **changed)


def coil_estimates(
    energies: Sequence[Energy], coils: Sequence[Coil], lines: Sequence[Line], u_noise: float
) -> tuple[Estimate, Estimate]:
    """Return W_coil of a condition, and W_coil - W_exp, J per cycle.

    lines: the budget of W_exp; u_noise: standard uncertainty of its mean from noise, J. An error of
    the acceleration (scale or angle) changes both equally, so it does not count in the difference.
    """
    n = len(coils)
    W = math.fsum(coil.W for coil in coils) / n
    own = []
    for same in zip(*(coil.lines for coil in coils), strict=False):
        # One line of every run: the same input, so that means take the place of u and c.
        u, c = math.fsum(line.u for line in same) / n, math.fsum(line.c for line in same) / n
        own.append(replace(same[0], u=u, c=c))
    noise = math.sqrt(math.fsum(coil.u_noise**2 for coil in coils)) / n
    of_runs = scatter_line([coil.W for coil in coils], stretch_of(lines))
    scatter = [(line.part, line.nu) for line in of_runs] or [(noise, math.inf)]
    shared = [
        line for line in lines if line.source.startswith(("acceleration", "clock", "arithmetic"))
    ]
    total = combine(W, [*scatter, *((line.part, line.nu) for line in (*own, *shared))])
    gauge = [(line.part, line.nu) for line in lines if line.source.startswith("force")]
    apart = math.fsum(coil.W - energy.W for coil, energy in zip(coils, energies, strict=True)) / n
    between = [
        *gauge,
        *((line.part, line.nu) for line in own),
        (noise, math.inf),
        (u_noise, math.inf),
    ]
    return total, combine(apart, between)


def _work(force: Complex, acceleration: Complex, frequency: float, first: int = 1) -> float:
    """Return the closed integral of F v dt, J per cycle, from phasors of harmonics first, first +
    1, ...
    """
    omega = 2 * math.pi * frequency * np.arange(first, first + force.size)
    return -0.5 / frequency * float(((force * acceleration.conj()).imag / omega).sum())
