"""Coil current and drive voltage in addition to force and acceleration, for prescribed motion: the
exciter solved backwards.
"""

import numpy as np
from numpy.typing import NDArray

from rig.catalog.entries import Exciter
from rig.drive.exciter_limits import need, solvable_band
from rig.stand.prescribed import Stand

Array = NDArray[np.float64]


class WithExciter:
    """A physical source: force, acceleration, coil current (A) and drive voltage (V) of a stand in
    prescribed motion.

    Each chunk of whole cycles is solved harmonic by harmonic as if it were periodic, up to
    `solvable_band`: the output that an ideal waveform controller would need. Impacts beyond that
    band appear in the force but not in the current.
    """

    def __init__(self, stand: Stand, exciter: Exciter) -> None:
        self.names = (*stand.names, "current", "voltage")
        self.rate = stand.rate
        self._stand, self._exciter = stand, exciter
        self._waiting = np.zeros((len(self.names), 0))

    def read(self, n: int) -> Array:
        """Return the next n interval means, shape (4, n)."""
        ready, size = [self._waiting], self._waiting.shape[1]
        while size < n:
            ready.append(self._advance())
            size += ready[-1].shape[1]
        joined = np.concatenate(ready, axis=1)
        self._waiting = joined[:, n:]
        return joined[:, :n]

    def _advance(self) -> Array:
        chunk = self._stand.advance()
        n = chunk.shape[1]
        jw = 2j * np.pi * np.fft.rfftfreq(n, 1.0 / self.rate)
        inside = slice(
            1, 1 + np.count_nonzero(np.abs(jw[1:]) <= 2.0 * np.pi * solvable_band(self._exciter))
        )
        pull, motion = (np.fft.rfft(row)[inside] for row in chunk)
        # Displacement from acceleration: x = a/(jw)^2.
        asked = need(self._exciter, pull, motion / jw[inside] ** 2, jw[inside])
        out = np.empty((4, n))
        out[:2] = chunk
        for row, spectrum in enumerate((asked.current, asked.voltage), start=2):
            whole = np.zeros(jw.size, complex)
            whole[inside] = spectrum
            out[row] = np.fft.irfft(whole, n)
        return out
