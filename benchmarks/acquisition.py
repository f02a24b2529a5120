"""The acquisition chain against scipy.signal.upfirdn doing its filter alone: `python -m benchmarks.acquisition`.

Side by side, in turn: eight channels through poles, anti-alias filter, skew, noise, conversion and flags; the
same oversampled signals through one call of upfirdn per channel with the whole filter in a single stage (the two stages
convolved, 57 + 4 x 142 taps), decimating by 8. Medians of pairs; the signals are drawn beforehand.
"""

import json
import statistics
import time

import numpy as np
from scipy import signal

from daq.acquisition import Emulated
from daq.channel import AnalyzerSpec, Channel, TransducerSpec, draw_state
from daq.fir import STAGE1, STAGE2
from daq.frontend import BLOCK, FrontEnd
from daq.seeds import stream
from daq.source import FloatArray
from daq.transducer import Transduced

CHANNELS, RATE, PAIRS = 8, 51200.0, 15
SPEC = TransducerSpec("208C03", "force", "N", 2.248e-3, 2200.0, 2000.0, 0.1, 0.02, 1e4, 0.01)


class Ready:
    """A physical source that hands out the same signals again and again."""

    names = tuple(f"ch{k}" for k in range(CHANNELS))
    rate = 8 * RATE

    def __init__(self, signals: FloatArray) -> None:
        self._signals = signals

    def read(self, n: int) -> FloatArray:
        """The first n intervals."""
        return self._signals[:, :n]


def chain(signals: FloatArray, skew: float) -> Emulated:
    """Eight channels as the product wires them."""
    analyzer = AnalyzerSpec("INV-3118", (RATE,), skew=skew)
    channels = [Channel(name, SPEC, 10.0, "", "+x") for name in Ready.names]
    states = [draw_state(channel, analyzer, stream(1, channel.name)) for channel in channels]
    noise = [stream(2, name) for name in Ready.names]
    return Emulated(Transduced(Ready(signals), states), FrontEnd(analyzer, channels, states, RATE, noise))


def measure(skew: float) -> dict[str, float]:
    """Samples per second (all channels together) of both, and their ratio."""
    signals = np.random.default_rng(0).standard_normal((CHANNELS, 8 * BLOCK))
    spread = np.zeros(4 * (len(STAGE2) - 1) + 1)
    spread[::4] = STAGE2
    whole = np.convolve(STAGE1, spread)
    acquisition = chain(signals, skew)
    acquisition.read(BLOCK)
    ours, theirs = [], []
    for _ in range(PAIRS):
        start = time.perf_counter()
        acquisition.read(BLOCK)
        ours.append(time.perf_counter() - start)
        start = time.perf_counter()
        for row in signals:
            signal.upfirdn(whole, row, 1, 8)
        theirs.append(time.perf_counter() - start)
    done = CHANNELS * BLOCK
    return {
        "chain_MS_per_s": 1e-6 * done / statistics.median(ours),
        "upfirdn_MS_per_s": 1e-6 * done / statistics.median(theirs),
        "ratio": statistics.median(b / a for a, b in zip(ours, theirs, strict=True)),
    }


if __name__ == "__main__":
    for name, skew in (("without skew", 0.0), ("with skew", 1.389e-7)):
        print(json.dumps({"name": f"acquisition chain, 8 channels, {name}", **measure(skew)}))
