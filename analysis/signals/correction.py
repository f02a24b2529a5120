"""Corrections by channel metadata: high-pass poles, delays between channels, mass between gauge and
box.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.signals.compiled_loops import with_integral

__all__ = ["advanced", "net_of_mass", "pole_phase", "without_pole"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def without_pole(signal: Array, time_constant: float, step: float) -> Array:
    """Return the input of a one-pole high pass j w tau / (1 + j w tau) from its output, less its
    mean.

    The output is a window of whole cycles. time_constant: tau in s; step: s. Every harmonic is
    multiplied by 1 + 1 / (j w tau), in time x = y + integral(y) / tau. The mean is removed first: a
    high pass does not transmit it.
    """
    return np.asarray(
        with_integral(np.ascontiguousarray(signal), signal.mean(), step / time_constant)
    )


def advanced(signal: Array, delay: float, step: float) -> Array:
    """Return a window of whole cycles moved `delay` s earlier: its spectrum times e^(jw delay)."""
    spectrum = np.fft.rfft(signal)
    spectrum *= np.exp(2j * np.pi * np.fft.rfftfreq(signal.size, step) * delay)
    return np.fft.irfft(spectrum, signal.size)


def pole_phase(omega: float, time_constant: float | None) -> float:
    """Return the phase lead of a high-pass pole at omega (rad/s), rad; its derivative to ln(tau) is
    -sin(2 phase) / 2.
    """
    return 0.0 if time_constant is None else float(np.arctan2(1.0, omega * time_constant))


def net_of_mass(force: Complex, acceleration: Complex, mass: float) -> Complex:
    """Return force phasors (N) less the force that a rigid mass (kg) needs at acceleration phasors
    (m/s^2): mass cancellation.
    """
    return force - mass * acceleration
