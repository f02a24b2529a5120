"""Analytic sources and a plain instrument for the tests of the acquisition."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from daq.chain.channel import AnalyzerSpec, Channel, ChannelState, ideal_analyzer, ideal_transducer
from daq.chain.frontend import BLOCK, FrontEnd

RATE = 10240.0
OVERSAMPLED = 8 * RATE


class Analytic:
    """A source (physical or analog) whose rows are functions of the interval index; reads of any
    size.
    """

    def __init__(
        self,
        *rows: Callable[[npt.NDArray[np.float64]], npt.NDArray[np.float64]],
        rate: float = OVERSAMPLED,
    ) -> None:
        self.names = tuple("ab"[: len(rows)])
        self.rate = rate
        self._rows = rows
        self.taken = 0

    def read(self, n: int) -> npt.NDArray[np.float64]:
        index = np.arange(self.taken, self.taken + n, dtype=float)
        self.taken += n
        return np.stack([row(index) for row in self._rows])

    volts = read


def tone(
    amplitude: float, frequency: float, phase: float = 0.0
) -> Callable[[npt.NDArray[np.float64]], npt.NDArray[np.float64]]:
    """Exact interval means of amplitude * sin(2 pi frequency t + phase); frequency in units of the
    output rate.
    """
    step = 2 * np.pi * frequency / 8
    droop = np.sinc(frequency / 8)
    return lambda index: amplitude * droop * np.sin(step * (index + 0.5) + phase)


def constant(value: float) -> Callable[[npt.NDArray[np.float64]], npt.NDArray[np.float64]]:
    return lambda index: np.full_like(index, value)


def channels(count: int) -> tuple[Channel, ...]:
    return tuple(Channel(name, ideal_transducer("force"), 10.0, "", "+x") for name in "ab"[:count])


def front_end(
    count: int = 1,
    analyzer: AnalyzerSpec | None = None,
    gain: float = 1.0,
    seed: int = 0,
    samples: int = BLOCK,
) -> FrontEnd:
    states = [ChannelState(1.0, None, gain)] * count
    noise = [np.random.default_rng((seed, row)) for row in range(count)]
    return FrontEnd(analyzer or ideal_analyzer(), channels(count), states, RATE, noise, samples)
