"""Steadiness of a record and its drive frequency: checked before the whole cycles of a foreign
record are used.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from analysis.session.record import AnalysisError

__all__ = [
    "FEWEST_CYCLES",
    "DriveLine",
    "Steadiness",
    "drive_frequency",
    "drive_line",
    "fundamental",
    "noise_rms",
    "steadiness",
]

Array = NDArray[np.float64]

FEWEST_CYCLES = 5  # of a record whose steadiness is judged
STRETCHES = 8
"""Number of equal stretches of whole cycles whose fundamentals are compared."""

NEAR = 0.45
"""Relative distance from a stated drive frequency within which its line is searched: it excludes
harmonics and the half frequency.
"""

LOWER_LINES = (5, 4, 3, 2)
"""Divisors of the strongest line's frequency at which the drive's own line is looked for."""

DRIVE, DOUBTFUL = 0.1, 0.02
"""Amplitude of a line at a fraction of the strongest one's frequency, over the strongest: from the first on
it is the drive, whose harmonic is stronger; from the second on it may be one, or a bed that repeats every
second cycle.
"""

ABOVE_FLOOR = 8.0  # amplitude of a line over the median of its neighbours

ROUNDS = 20  # most refinements of a frequency
CONVERGED = 1e-12  # relative change of the frequency that ends the refinement


@dataclass(frozen=True, slots=True)
class Steadiness:
    """The deviation of a record from a steady one.

    level : largest less least amplitude of the fundamental over the stretches, over its mean
    phase : largest deviation of the stretches' phases from a straight line, rad
    residual : rms of the part that is not periodic over the fundamental's
    """

    level: float
    phase: float
    residual: float


@dataclass(frozen=True, slots=True)
class DriveLine:
    """The drive frequency found in a record, Hz.

    told : what was decided, where a harmonic is stronger than the drive
    doubt : whether a weaker line at a fraction of it may be the drive
    """

    frequency: float
    told: str = ""
    doubt: bool = False


def drive_line(signal: Array, rate: float, nominal: float | None = None) -> DriveLine:
    """Return the drive of a record: the line near a nominal frequency (Hz), or without one the
    strongest, unless it is a harmonic of a lower line. Raises AnalysisError where there is no sine.
    """
    strongest = drive_frequency(signal, rate, nominal)
    if nominal is not None:
        return DriveLine(strongest)
    whole, _ = _amplitude(signal, rate, strongest)
    for divisor in LOWER_LINES:
        frequency = strongest / divisor
        if frequency * signal.size < FEWEST_CYCLES * rate:
            continue
        amplitude, floor = _amplitude(signal, rate, frequency)
        if amplitude < DOUBTFUL * whole or amplitude < ABOVE_FLOOR * floor:
            continue
        if amplitude < DRIVE * whole:
            return DriveLine(strongest, doubt=True)
        # The refinement by the stronger harmonic is the better one.
        told = f"drive at {frequency:.6g} Hz, whose harmonic {divisor} is {whole / amplitude:.3g} times stronger"
        return DriveLine(frequency, told)
    return DriveLine(strongest)


def _amplitude(signal: Array, rate: float, frequency: float) -> tuple[float, float]:
    """Return the amplitude of a line, and the median of those 4 to 8 resolutions beside it."""
    count = signal.size
    window = np.hanning(count)
    x = (signal - signal.mean()) * window
    offsets = np.array([0.0, *range(-8, -3), *range(4, 9)])
    times = np.arange(count) / rate
    found = [
        abs(x @ np.exp(-2j * np.pi * (frequency + offset * rate / count) * times))
        * 2
        / window.sum()
        for offset in offsets
    ]
    return float(found[0]), float(np.median(found[1:]))


def drive_frequency(signal: Array, rate: float, guess: float | None = None) -> float:
    """Return the frequency of the strongest sine in a record, Hz.

    guess: Hz; the strongest line within `NEAR` of it, or without a guess the strongest above the
    two lowest. The frequency is refined by the phase difference between the two halves of the
    record, Hann-weighted, until it converges: exact for a sine, and for one with harmonics as far
    as the window separates them. AnalysisError where there is no sine.
    """
    count = signal.size
    window = np.hanning(count)
    x = (signal - signal.mean()) * window
    spectrum = np.abs(np.fft.rfft(x))
    if guess is None:
        spectrum[:3] = 0.0
    else:
        apart = np.fft.rfftfreq(count, 1 / rate) / guess - 1
        spectrum[np.abs(apart) > max(NEAR, rate / count / guess)] = 0.0
    line = int(np.argmax(spectrum))
    if not spectrum[line] > 0.0:
        raise AnalysisError("the record holds no oscillation")
    frequency = guess = line * rate / count
    for _ in range(ROUNDS):
        step = _correction(signal, rate, frequency)
        frequency += step
        if not 0.0 < frequency < rate / 2 or not math.isfinite(frequency):
            raise AnalysisError(f"no steady frequency near {guess:.4g} Hz was found")
        if abs(step) < CONVERGED * frequency:
            break
    return frequency


def _correction(signal: Array, rate: float, frequency: float) -> float:
    """Return the frequency error that follows from the phase difference of two half records, Hz."""
    half = signal.size // 2
    turn = np.exp(-2j * np.pi * frequency / rate * np.arange(half))
    window = np.hanning(half)
    first, second = (
        ((part - part.mean()) * window) @ turn for part in (signal[:half], signal[half : 2 * half])
    )
    expected = np.exp(2j * np.pi * frequency / rate * half)
    return float(np.angle(second * np.conj(first * expected))) * rate / (2 * math.pi * half)


def steadiness(signal: Array, rate: float, frequency: float) -> Steadiness:
    """Return the steadiness of a record at `rate` (Hz) with its drive frequency (Hz). AnalysisError
    below FEWEST_CYCLES cycles.
    """
    period = rate / frequency
    cycles = math.floor(signal.size / period)
    if cycles < FEWEST_CYCLES:
        raise AnalysisError(
            f"{cycles} whole cycles at {frequency:.6g} Hz: at least {FEWEST_CYCLES} are needed"
        )
    stretches = min(STRETCHES, cycles)
    edges = [round(n * (cycles // stretches) * period) for n in range(stretches + 1)]
    phasors = np.array([fundamental(signal[a:b], a, rate, frequency) for a, b in pairwise(edges)])
    levels, phases = np.abs(phasors), np.unwrap(np.angle(phasors))
    line = np.polynomial.Polynomial.fit(np.arange(stretches), phases, 1)
    return Steadiness(
        level=float(np.ptp(levels) / levels.mean()),
        phase=float(np.abs(phases - line(np.arange(stretches))).max()),
        residual=_residual(signal[: edges[-1]], period) / float(levels.mean() / math.sqrt(2)),
    )


def fundamental(part: Array, start: int, rate: float, frequency: float) -> complex:
    """Return the phasor of a stretch by least squares of sine, cosine and mean (a stretch need not
    be whole cycles long).
    """
    angle = 2 * math.pi * frequency / rate * (start + np.arange(part.size))
    basis = np.stack([np.cos(angle), -np.sin(angle), np.ones(part.size)], axis=1)
    cosine, sine, _ = np.linalg.lstsq(basis, part, rcond=None)[0]
    return complex(cosine, sine)


def noise_rms(signal: Array, period: float) -> float:
    """Return the rms of the part that does not repeat from cycle to cycle, in the unit of the
    signal.

    period: of the drive, samples.
    """
    return _residual(signal, period)


def _residual(signal: Array, period: float) -> float:
    """Return the rms over sqrt(2) of the signal less itself one period later (linear interpolation
    between samples).
    """
    whole, part = divmod(period, 1.0)
    later = signal[int(whole) :]
    later = later[:-1] * (1 - part) + later[1:] * part
    gap = signal[: later.size] - later
    scale = math.sqrt(1 + (1 - part) ** 2 + part**2)
    return float(np.sqrt(np.mean(gap * gap))) / scale
