"""Compiled loops over samples and over simulated sessions: one pass each instead of ten array
operations, and no temporary arrays.

Sums run in the order of the samples, without reassociation: equal samples give equal bits.
"""

import numpy as np
from numpy.typing import NDArray

from daq.compiled import njit

__all__ = [
    "CycleSums",
    "covered",
    "cycle_features",
    "cycle_sums",
    "errors_of_means",
    "with_integral",
]

Array = NDArray[np.float64]
CycleSums = tuple[Array, Array, Array, Array, Array, Array, Array]


@njit(cache=True, nogil=True)
def with_integral(signal: Array, mean: float, weight: float) -> Array:
    """Return y + weight * integral(y), y = signal - mean, for a unit step.

    The rule is that of `analysis.signals.integration.integral`.
    """
    n = signal.size
    out = np.empty(n)
    # Trapezoid up to sample i, less 1/12 of the slope there (Euler-Maclaurin), which is the central
    # difference over 2. The ends wrap around: the window is periodic.
    total, before, here = 0.0, signal[n - 1] - mean, signal[0] - mean
    for i in range(n):
        after = signal[i + 1 if i + 1 < n else 0] - mean
        total += here
        out[i] = here + weight * (total - 0.5 * here - (after - before) * (1 / 24))
        before, here = here, after
    return out


@njit(cache=True, nogil=True)
def cycle_sums(force: Array, acceleration: Array, mean: float, cycles: int) -> CycleSums:
    """Return the sums over each cycle from which energies are computed.

    force, acceleration: (cycles * points,); mean: of the acceleration. Per cycle, (cycles,): the
    sums of F, of a, of k F (k = 0, 1, ... in the cycle), of u and of F u, and u at its start, where
    u = integral(a - mean) over the whole window for a unit step. Last, (2, points): the sums over
    the cycles of each point's F and a.
    """
    points = force.size // cycles
    n = cycles * points
    F_sum, a_sum, kF_sum = np.zeros(cycles), np.zeros(cycles), np.zeros(cycles)
    u_sum, Fu_sum, u_first = np.zeros(cycles), np.zeros(cycles), np.zeros(cycles)
    shape = np.zeros((2, points))
    total, before, here = 0.0, acceleration[n - 1] - mean, acceleration[0] - mean
    for c in range(cycles):
        first = c * points
        Fs, as_, kFs, us, Fus = 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(points):
            i = first + k
            after = acceleration[i + 1 if i + 1 < n else 0] - mean
            total += here
            u = total - 0.5 * here - (after - before) * (1 / 24)
            before, here = here, after
            F, a = force[i], acceleration[i]
            if k == 0:
                u_first[c] = u
            Fs += F
            as_ += a
            kFs += k * F
            us += u
            Fus += F * u
            shape[0, k] += F
            shape[1, k] += a
        F_sum[c], a_sum[c], kF_sum[c], u_sum[c], Fu_sum[c] = Fs, as_, kFs, us, Fus
    return F_sum, a_sum, kF_sum, u_sum, Fu_sum, u_first, shape


@njit(cache=True, nogil=True)
def cycle_features(
    samples: Array, cycles: int, turn: Array
) -> tuple[Array, Array, Array, Array, float]:
    """Return features of a window (cycles * points,) for `analysis.signals.quality`.

    Per cycle: mean; the sums of x cos and -x sin, (cycles, 2); rms and largest magnitude of the
    second differences of x less the mean cycle. Last the largest magnitude of all samples. turn:
    (2, points), cosine and negative sine over a cycle.
    """
    points = samples.size // cycles
    mean, parts = np.zeros(cycles), np.zeros((cycles, 2))
    rms, top = np.zeros(cycles), np.zeros(cycles)
    usual = np.zeros(points)
    peak = 0.0
    for c in range(cycles):
        x = samples[c * points : (c + 1) * points]
        total, real, imaginary = 0.0, 0.0, 0.0
        for k in range(points):
            value = x[k]
            total += value
            real += value * turn[0, k]
            imaginary += value * turn[1, k]
            usual[k] += value
            peak = max(peak, abs(value))
        mean[c], parts[c, 0], parts[c, 1] = total / points, real, imaginary
    usual /= cycles
    for c in range(cycles):
        x = samples[c * points : (c + 1) * points]
        square, most = 0.0, 0.0
        one, two = x[0] - usual[0], x[1] - usual[1]
        for k in range(2, points):
            three = x[k] - usual[k]
            bend = three + one - 2 * two
            square += bend * bend
            most = max(most, abs(bend))
            one, two = two, three
        rms[c], top[c] = np.sqrt(square / (points - 2)), most
    return mean, parts, rms, top, peak


@njit(cache=True, nogil=True)
def errors_of_means(values: Array, places: NDArray[np.uint32]) -> tuple[Array, Array]:
    """Return the mean of drawn values and its standard uncertainty from their scatter, (count,)
    each.

    values: to draw from, less their mean; places: the drawn ones of each session, (n, count).
    """
    n, count = places.shape
    mean, square = np.zeros(count), np.zeros(count)
    for i in range(n):
        for j in range(count):
            mean[j] += values[places[i, j]]
    for j in range(count):
        mean[j] /= n
    for i in range(n):
        for j in range(count):
            apart = values[places[i, j]] - mean[j]
            square[j] += apart * apart
    for j in range(count):
        square[j] = np.sqrt(square[j] / ((n - 1) * n))
    return mean, square


@njit(cache=True, nogil=True)
def covered(
    error: Array, scatter: Array, certified: float, normal: Array, factor: float, k: Array
) -> int:
    """Return in how many sessions the error of a mean is at most its expanded uncertainty.

    error: of the mean of the refills; scatter: its standard uncertainty, which `factor` multiplies;
    certified: standard uncertainty of the instruments; normal: their error over it; k: coverage
    factor at equally spaced fractions of the variance, from 0 to 1, that are the refills'.
    """
    found, steps = 0, k.size - 1
    for j in range(error.size):
        own = (factor * scatter[j]) ** 2
        whole = own + certified * certified
        share = own / whole if whole > 0 else 0.0
        step = min(int(share * steps), steps - 1)
        limit = k[step] + (k[step + 1] - k[step]) * (share * steps - step)
        found += abs(error[j] + certified * normal[j]) <= limit * np.sqrt(whole)
    return found
