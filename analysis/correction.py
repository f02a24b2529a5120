"""What the channel metadata says must be undone: high-pass poles, delays between channels, the mass before the box."""

import numpy as np
from numpy.typing import NDArray

__all__ = ["channel_correction", "net_of_mass", "pole_phase"]

Complex = NDArray[np.complex128]


def channel_correction(
    omega: NDArray[np.floating], time_constant: float | None = None, delay: float = 0.0
) -> Complex | None:
    """Factor that turns a channel's spectrum back into its input, at angular frequencies omega > 0 (rad/s).

    time_constant: s, of a one-pole high pass j w tau / (1 + j w tau), None for none; delay: s by which the channel lags
    the reference. None where nothing is to be corrected.
    """
    factor: Complex | None = None
    if time_constant is not None:
        factor = np.asarray(1 - 1j / (omega * time_constant), dtype=np.complex128)
    if delay:
        shift: Complex = np.exp(1j * omega * delay)
        factor = shift if factor is None else factor * shift
    return factor


def pole_phase(omega: float, time_constant: float | None) -> float:
    """Phase lead in rad of a high-pass pole at omega (rad/s); its derivative to ln(tau) is -sin(2 phase) / 2."""
    return 0.0 if time_constant is None else float(np.arctan2(1.0, omega * time_constant))


def net_of_mass(force: Complex, acceleration: Complex, mass: float) -> Complex:
    """Force phasors (N) less what a rigid mass (kg) needs at acceleration phasors (m/s^2): mass cancellation."""
    return force - mass * acceleration
