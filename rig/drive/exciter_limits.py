"""Exciter requirements of a prescribed motion: the hardware equations solved backwards, harmonic by
harmonic.
"""

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
"""Masses, stiffnesses and damping of an exciter, each known within its relative uncertainty
`parts_U`.
"""


@dataclass(frozen=True)
class Demand:
    """Utilisation of the exciter's limits by a motion, each a fraction of the limit (1 = at the
    limit).

    The first four are rated on the fundamental, because manufacturers rate a sine force. `peak` is
    the largest gauge force within the recorded band over the force rating (a real box would recoil
    instead); `buckling` is the same force over the stinger's buckling load.
    """

    force: float
    current: float
    voltage: float
    stroke: float
    peak: float
    buckling: float

    def scalars(self) -> dict[str, float]:
        """Return the values under the names of the session file."""
        return {f"use_{name}": value for name, value in asdict(self).items()}


@dataclass(frozen=True)
class Need:
    """Spectra of the quantities that the exciter has to supply.

    coil_force : force on the coil BL i, N
    stroke : displacement of the armature relative to the body, m
    current : coil current, A
    voltage : drive voltage, V
    """

    coil_force: Spectrum
    stroke: Spectrum
    current: Spectrum
    voltage: Spectrum


def need(exciter: Exciter, pull: Spectrum, box: Spectrum, jw: Spectrum) -> Need:
    """Return the exciter quantities that give the stinger force F_gauge (N) and box displacement
    (m).

    pull : F_gauge at each jw; box : displacement at each jw; jw : j times the angular frequency, w
        > 0.

    The stinger force, inertia and flexure act on the armature; the body recoils on its isolation:
    m_a x_a'' + c_s (x_a' - x_b') + k_s (x_a - x_b) + F_gauge = BL i, m_b x_b'' + isolation - (..)_s
    = -BL i,
    e = R i + L i' + BL (x_a' - x_b'), x_a = x + F_gauge / (k_st + j w c_st).
    """
    armature = box + pull / (exciter.stinger_stiffness + jw * exciter.stinger_damping)
    flexure = _spring(
        exciter.flexure_stiffness, exciter.flexure_damping_ratio, exciter.moving_mass, jw
    )
    mount = _spring(
        exciter.isolation_stiffness, exciter.isolation_damping_ratio, exciter.body_mass, jw
    )
    thrust_on_body = exciter.moving_mass * jw**2 * armature + pull
    body = -thrust_on_body / (exciter.body_mass * jw**2 + mount)
    relative = armature - body
    coil_force = thrust_on_body + flexure * relative
    current = coil_force / exciter.force_constant
    voltage = (
        exciter.resistance + jw * exciter.inductance
    ) * current + exciter.force_constant * jw * relative
    return Need(coil_force, relative, current, voltage)


def demand(exciter: Exciter, force: Array, rate: float, motion: Waveform, band: float) -> Demand:
    """Return the exciter utilisation of a steady stretch of gauge force (N, sampled at `rate`),
    using harmonics up to `band` (Hz).
    """
    cycles = max(int(force.size * motion.frequency / rate + 1e-9), 1)
    samples = min(round(cycles * rate / motion.frequency), force.size)
    spectrum = 2.0 * np.fft.rfft(force[:samples]) / samples
    order = np.arange(spectrum.size) / cycles
    # The mean of the force (order 0) is carried by the mount, not by the coil.
    pull = np.where((order > 0.0) & (order * motion.frequency <= band), spectrum, 0.0)
    box = np.zeros_like(pull)
    for h, (sine, cosine) in enumerate(zip(motion.sine, motion.cosine, strict=True), start=1):
        # Sign convention: x = X sin(h wt) has the phasor -j X under Re(phasor e^(+jwt)).
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
    """Return half the resonance frequency of the armature on its stinger, Hz.

    Above it the coil current carries little information on the gauge force, and an ideal waveform
    would need currents that grow as w^2.
    """
    return float(0.5 / (2.0 * np.pi) * np.sqrt(exciter.stinger_stiffness / exciter.moving_mass))


def _spring(stiffness: float, ratio: float, mass: float, jw: Spectrum) -> Spectrum:
    """Return the dynamic stiffness k + jw c, N/m, with c = 2 zeta sqrt(k m)."""
    return stiffness + jw * float(2.0 * ratio * np.sqrt(stiffness * mass))
