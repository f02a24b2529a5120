"""Whether a record is steady, and at which frequency: before whole cycles of somebody else's record
are trusted.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from analysis.session.record import AnalysisError

__all__ = ["FEWEST_CYCLES", "Steadiness", "drive_frequency", "fundamental", "steadiness"]

Array = NDArray[np.float64]

FEWEST_CYCLES = 5
STRETCHES = 8
"""Equal stretches of whole cycles whose fundamentals are compared."""

NEAR = 0.45
"""How far from a stated drive frequency, relative, its line is looked for: neither a harmonic nor
half of it.
"""

ROUNDS = 20
CONVERGED = 1e-12


@dataclass(frozen=True, slots=True)
class Steadiness:
    """How far a record is from a steady one.

    level: (largest - least) amplitude of the fundamental over the stretches, over its mean; phase:
    largest deviation of the stretches' phases from a straight line, rad; residual: rms of what is
    no harmonic over the fundamental's.
    """

    level: float
    phase: float
    residual: float


def drive_frequency(signal: Array, rate: float, guess: float | None = None) -> float:
    """Frequency of the strongest sine in a record, Hz.

    guess: Hz; the strongest line within `NEAR` of it is taken, None: the strongest above the first
    two. It is refined by the phase slope of the fundamental over two halves of a Hann-weighted
    record, to convergence: exact for a sine, and for one with harmonics as far as the window keeps
    them apart. AnalysisError where there is no sine to be found.
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
    """Frequency error from the phase that two half records differ by, Hz."""
    half = signal.size // 2
    turn = np.exp(-2j * np.pi * frequency / rate * np.arange(half))
    window = np.hanning(half)
    first, second = (
        ((part - part.mean()) * window) @ turn for part in (signal[:half], signal[half : 2 * half])
    )
    expected = np.exp(2j * np.pi * frequency / rate * half)
    return float(np.angle(second * np.conj(first * expected))) * rate / (2 * math.pi * half)


def steadiness(signal: Array, rate: float, frequency: float) -> Steadiness:
    """How steady a record at `rate` (Hz) is at its drive frequency (Hz). AnalysisError below
    FEWEST_CYCLES cycles.
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
    """Least-squares phasor of a stretch: sine, cosine and mean (a stretch need not be whole samples
    long).
    """
    angle = 2 * math.pi * frequency / rate * (start + np.arange(part.size))
    basis = np.stack([np.cos(angle), -np.sin(angle), np.ones(part.size)], axis=1)
    cosine, sine, _ = np.linalg.lstsq(basis, part, rcond=None)[0]
    return complex(cosine, sine)


def noise_rms(signal: Array, period: float) -> float:
    """Rms of what does not repeat from cycle to cycle (unit of the signal): differences of
    neighbours a cycle apart.
    """
    return _residual(signal, period)


def _residual(signal: Array, period: float) -> float:
    """Rms over sqrt(2) of the signal less itself one period later (linear interpolation between
    samples).
    """
    whole, part = divmod(period, 1.0)
    later = signal[int(whole) :]
    later = later[:-1] * (1 - part) + later[1:] * part
    gap = signal[: later.size] - later
    scale = math.sqrt(1 + (1 - part) ** 2 + part**2)
    return float(np.sqrt(np.mean(gap * gap))) / scale
