"""Dissipated energy per cycle from force and acceleration, by three estimators.

Signs: force acts on the box, positive along the drive axis; e^(+jwt); W > 0 for a dashpot. `loop`:
closed integral of F v dt over each cycle. `phasor`: -pi / (w h w) Im(F_h A_h*) summed over the
harmonics h of the whole window. `eq25`: W_exc - W_kin of the paper's eq. 25. On whole cycles they
agree by Parseval's theorem: that checks the arithmetic, and is no independent evidence.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.energy.energy_and_phasors import Energy
from analysis.signals.compiled_loops import CycleSums, cycle_sums
from analysis.signals.correction import advanced, without_pole
from analysis.signals.cycles import on_grid, whole_cycles

__all__ = ["Total", "dissipated_energy", "harmonics", "window_energy"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Poles = float | Sequence[float] | None  # s, time constants of a channel's high-pass poles

DRIFTING = 16  # fewest cycles whose means show a drift
SURE = 10.0
"""Slope over its standard deviation that is a drift: cycles of a bed are not independent (as in
analysis.signals.quality)."""

PASS_BAND = 0.45
"""Fraction of the sampling rate up to which harmonics count: above it the anti-alias filter falls off."""


def dissipated_energy(
    force: Array,
    acceleration: Array,
    rate: float,
    frequency: float,
    *,
    cycles: int | None = None,
    settle: float = 0,
    filter_delay: float = 0.0,
    time_constants: tuple[Poles, Poles] = (None, None),
    delay: float = 0.0,
    box_mass: float = 0.0,
) -> Energy:
    """Return the energy per cycle that everything beyond the force gauge dissipates.

    force (N) and acceleration (m/s^2): 1-D, equally long, sampled together at `rate` (Hz) and
    driven at `frequency` (Hz). settle, cycles, filter_delay: see whole_cycles; all whole cycles are
    used by default. time_constants: s, of the high-pass poles of the two channels (None, one, or
    several), corrected harmonic by harmonic. delay: s by which the acceleration channel lags the
    force channel. box_mass: kg, for W_kin. ValueError where shapes differ, a sample is not finite
    or no whole cycle fits.
    """
    force, acceleration = np.asarray(force, dtype=float), np.asarray(acceleration, dtype=float)
    if force.ndim != 1 or force.shape != acceleration.shape:
        raise ValueError(
            f"force {force.shape} and acceleration {acceleration.shape} must be 1-D and equally long"
        )
    if not (np.isfinite(force).all() and np.isfinite(acceleration).all()):
        raise ValueError("force and acceleration must be finite")
    window = whole_cycles(
        force.size, rate, frequency, filter_delay=filter_delay, settle=settle, cycles=cycles
    )
    both = np.stack([force, acceleration])
    total = Total()
    for part in window.segments():
        f, a = on_grid(both, 0, part)
        total.add(
            window_energy(
                f,
                a,
                part.cycles,
                frequency,
                time_constants=time_constants,
                delay=delay,
                box_mass=box_mass,
            )
        )
    return total.energy()


def window_energy(
    force: Array,
    acceleration: Array,
    cycles: int,
    frequency: float,
    *,
    time_constants: tuple[Poles, Poles] = (None, None),
    delay: float = 0.0,
    box_mass: float = 0.0,
) -> Energy:
    """Return the energies of a window of `cycles` whole cycles, each with a whole number of points.

    See dissipated_energy.
    """
    points = force.size // cycles
    step = 1 / (frequency * points)
    force = _without_trend(_corrected(force, step, time_constants[0], 0.0), cycles)
    acceleration = _without_trend(_corrected(acceleration, step, time_constants[1], delay), cycles)
    sums = cycle_sums(
        np.ascontiguousarray(force), np.ascontiguousarray(acceleration), acceleration.mean(), cycles
    )
    force_h, acceleration_h = (_phasors(shape / cycles) for shape in sums[-1])
    W_cycles = _loop(sums, points, step)
    W_exc, W_kin = _literal(sums, points, step, box_mass)
    omega = 2 * math.pi * frequency * np.arange(1, force_h.size + 1)
    return Energy(
        frequency=frequency,
        cycles=cycles,
        W=float(W_cycles.mean()),
        W_cycles=W_cycles,
        W_exc=W_exc,
        W_kin=W_kin,
        W_phasor=-0.5 / frequency * float(((force_h * acceleration_h.conj()).imag / omega).sum()),
        force=force_h,
        acceleration=acceleration_h,
    )


class Total:
    """The energies of consecutive windows as those of one: means weighted with the number of cycles
    (the phasors are coherent).
    """

    def __init__(self) -> None:
        self._first: Energy | None = None
        self._cycles = 0
        self._W_cycles: list[Array] = []
        self._sums: tuple[Any, ...] = ()

    def add(self, part: Energy) -> None:
        """Add the next window."""
        n = part.cycles
        own = (
            n * part.W,
            n * part.W_exc,
            n * part.W_kin,
            n * part.W_phasor,
            n * part.force,
            n * part.acceleration,
        )
        self._sums = (
            tuple(a + b for a, b in zip(self._sums, own, strict=True)) if self._first else own
        )
        self._first = self._first or part
        self._cycles += n
        self._W_cycles.append(part.W_cycles)

    def energy(self) -> Energy:
        """Return the energies of all windows so far. ValueError without any."""
        if self._first is None:
            raise ValueError("no window")
        if len(self._W_cycles) == 1:
            return self._first
        W, W_exc, W_kin, W_phasor, force, acceleration = (
            each / self._cycles for each in self._sums
        )
        return Energy(
            self._first.frequency,
            self._cycles,
            W,
            np.concatenate(self._W_cycles),
            W_exc,
            W_kin,
            W_phasor,
            force,
            acceleration,
        )


def _corrected(signal: Array, step: float, poles: Poles, delay: float) -> Array:
    """Return a window with its delay and its poles corrected."""
    if delay:
        signal = advanced(signal, delay, step)
    if poles is None:
        poles = ()
    elif isinstance(poles, float | int):
        poles = (poles,)
    for time_constant in poles:
        signal = without_pole(signal, time_constant, step)
    return signal


def _without_trend(signal: Array, cycles: int) -> Array:
    """Return a window less the straight line through the means of its cycles, where these drift by
    more than their scatter explains; otherwise unchanged.

    A drift does no work, but within a cycle its slope s adds s times the integral of t v dt to the
    loop. The means are those of whole cycles: harmonics of the drive do not enter the line.
    """
    if cycles < DRIFTING:
        return signal
    points = signal.size // cycles
    means = signal.reshape(cycles, points).mean(axis=1)
    middle = np.arange(cycles) - (cycles - 1) / 2
    square = float(middle @ middle)
    slope = float(means @ middle) / square
    rest = means - means.mean() - slope * middle
    if slope**2 * square <= SURE**2 * float(rest @ rest) / (cycles - 2):
        return signal
    return signal - slope / points * (np.arange(signal.size) - (signal.size - 1) / 2)


def harmonics(signal: Array, cycles: int, points: int) -> Complex:
    """Return the peak phasors of harmonics 1, 2, ... of the drive, up to the edge of the pass band.

    At these frequencies the spectrum of the mean cycle equals that of the whole window.
    """
    return _phasors(signal.reshape(cycles, points).mean(axis=0))


def _phasors(cycle: Array) -> Complex:
    """Return the peak phasors of a mean cycle, (points,)."""
    points = cycle.size
    return np.fft.rfft(cycle)[1 : max(1, int(PASS_BAND * points)) + 1] * (2 / points)


def _loop(sums: CycleSums, points: int, step: float) -> Array:
    """Return the closed integral of F v dt of every cycle, (cycles,), means removed cycle by cycle.

    u integrates the acceleration less the mean of the whole window; the difference to a cycle's own
    mean integrates to a straight line, which is subtracted here.
    """
    F, a, kF, u, Fu, _, _ = sums
    slope = (a - a.mean()) / points  # a.mean() / points is the window's mean
    steady = Fu - F * u / points
    return np.asarray((steady - slope * (kF - F * (points - 1) / 2)) * step**2)


def _literal(sums: CycleSums, points: int, step: float, box_mass: float) -> tuple[float, float]:
    """Return W_exc and W_kin of eq. 25, J per cycle, from one integration over the whole window.

    The offset of an accelerometer makes the velocity drift: the line through the means of the
    cycles is subtracted. (Subtracting the mean acceleration would not do: it contains the box's own
    change of speed, and W_kin would vanish by construction.)
    """
    F, _, kF, u, Fu, u_first, _ = sums
    cycles = F.size
    middle = np.arange(cycles) - (cycles - 1) / 2
    means = u / points
    slope = float((means * middle).sum()) / float((middle * middle).sum()) if cycles > 1 else 0.0
    # The line at the start of each cycle: the middle of its points comes (1 - 1/points)/2 later.
    line = float(means.mean()) + slope * (middle - (1 - 1 / points) / 2)
    W_exc = float((Fu - line * F - slope / points * kF).sum()) * step**2 / cycles
    first, last = float(u_first[0] - line[0]) * step, float(u_first[-1] - line[-1]) * step
    W_kin = 0.5 * box_mass * (last**2 - first**2) / (cycles - 1) if cycles > 1 else 0.0
    return W_exc, W_kin
