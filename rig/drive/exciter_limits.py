"""What a motion asks of the exciter: hardware equations solved backwards, harmonic by harmonic, servo drive."""

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from rig.catalog.entries import Exciter
from rig.drive.waveform import Waveform

Array = NDArray[np.float64]
Spectrum = NDArray[np.complexfloating]

PARTS = (
    "moving_mass", "flexure_stiffness", "flexure_damping_ratio", "body_mass", "isolation_stiffness",
    "isolation_damping_ratio", "stinger_stiffness", "stinger_damping",
)  # fmt: skip
"""Masses, stiffnesses and damping of an exciter, known within its `parts_U`."""


@dataclass(frozen=True)
class Demand:
    """Shares of the exciter's limits that a motion uses (1 = at the limit).

    The first four are rated on the fundamental, as makers rate a sine force; `peak` is the largest gauge force within
    the recorded band against the force rating (a real box would recoil there instead), `buckling` the same against
    the stinger's buckling load.
    """

    force: float
    current: float
    voltage: float
    stroke: float
    peak: float
    buckling: float

    def scalars(self) -> dict[str, float]:
        """By the names of the session file."""
        return {f"use_{name}": value for name, value in asdict(self).items()}


@dataclass(frozen=True)
class Need:
    """What a motion needs of the exciter, spectra: force on the coil BL i in N, armature against body in m, coil
    current in A and drive voltage in V."""

    coil_force: Spectrum
    stroke: Spectrum
    current: Spectrum
    voltage: Spectrum


def need(exciter: Exciter, pull: Spectrum, box: Spectrum, jw: Spectrum) -> Need:
    """The exciter solved backwards from the stinger's pull F_gauge (N) and the box's displacement (m) at each jw > 0.

    The armature feels the stinger's pull, its own inertia and its flexure; the body recoils on its isolation:
    m_a x_a'' + c_s (x_a' - x_b') + k_s (x_a - x_b) + F_gauge = BL i, m_b x_b'' + isolation - (..)_s = -BL i,
    e = R i + L i' + BL (x_a' - x_b'), x_a = x + F_gauge / (k_st + j w c_st).
    """
    armature = box + pull / (exciter.stinger_stiffness + jw * exciter.stinger_damping)
    flexure = _spring(exciter.flexure_stiffness, exciter.flexure_damping_ratio, exciter.moving_mass, jw)
    mount = _spring(exciter.isolation_stiffness, exciter.isolation_damping_ratio, exciter.body_mass, jw)
    thrust_on_body = exciter.moving_mass * jw**2 * armature + pull
    body = -thrust_on_body / (exciter.body_mass * jw**2 + mount)
    relative = armature - body
    coil_force = thrust_on_body + flexure * relative
    current = coil_force / exciter.force_constant
    voltage = (exciter.resistance + jw * exciter.inductance) * current + exciter.force_constant * jw * relative
    return Need(coil_force, relative, current, voltage)


def demand(exciter: Exciter, force: Array, rate: float, motion: Waveform, band: float) -> Demand:
    """Exciter use for a steady stretch of gauge force (N, at `rate`), harmonics up to `band` (Hz)."""
    cycles = max(int(force.size * motion.frequency / rate + 1e-9), 1)
    samples = min(round(cycles * rate / motion.frequency), force.size)
    spectrum = 2.0 * np.fft.rfft(force[:samples]) / samples
    order = np.arange(spectrum.size) / cycles
    pull = np.where((order > 0.0) & (order * motion.frequency <= band), spectrum, 0.0)
    box = np.zeros_like(pull)
    for h, (sine, cosine) in enumerate(zip(motion.sine, motion.cosine, strict=True), start=1):
        box[h * cycles] = motion.length_unit / h**2 * (cosine - 1j * sine)
    asked = need(exciter, pull, box, 1j * motion.omega * order)
    used = {
        "force": asked.coil_force / exciter.force_peak,
        "current": asked.current / exciter.current_peak,
        "voltage": asked.voltage / exciter.voltage_peak,
        "stroke": asked.stroke / exciter.stroke,
    }
    rated = {name: float(abs(share[cycles])) for name, share in used.items()}
    peak = float(np.abs(np.fft.irfft(0.5 * samples * pull, n=samples)).max())
    return Demand(**rated, peak=peak / exciter.force_peak, buckling=peak / exciter.stinger_buckling)


def solvable_band(exciter: Exciter) -> float:
    """Half the resonance of the armature on its stinger, Hz: above it the coil's current says little about the force at
    the gauge, and an ideal waveform would ask for currents that grow as w^2."""
    return float(0.5 / (2.0 * np.pi) * np.sqrt(exciter.stinger_stiffness / exciter.moving_mass))


def _spring(stiffness: float, ratio: float, mass: float, jw: Spectrum) -> Spectrum:
    """Dynamic stiffness k + jw c, N/m, with c = 2 zeta sqrt(k m)."""
    return stiffness + jw * float(2.0 * ratio * np.sqrt(stiffness * mass))
