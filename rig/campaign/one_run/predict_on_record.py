"""W_T on the recorded waveform: the event-resolved model driven by the measured acceleration of the
box.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.signals.correction import without_pole
from analysis.signals.cycles import Window, on_grid, whole_cycles
from daq.chain.block import Block
from daq.chain.channel import ChannelInfo
from rig.beds.column import rows_of
from rig.beds.janssen_stack import nominal
from rig.campaign.one_run.part import RECORDED_SCALARS
from rig.catalog.entries import Rig
from rig.kernels.rows.recorded_motion import sampled_energy
from rig.protocol.schedule import Lengths
from rig.protocol.spec import BEDS_OF_ROWS, Condition

SETTLE = 10
"""Cycles of the rows before their energies count."""

RAMP = {"prescribed": 0, "shaker": 10}
"""Cycles before those, by drive, in which the motion grows.

Rows with several orbits at one level settle on different ones if the motion starts at once, as in
prescribed motion, or gradually, under level control.
"""

STILL = ("empty", "locked", "dashpot", "loop_back")
"""Beds that dissipate nothing in the model."""


class Listener:
    """Predictor of W_T from the recorded acceleration.

    It stores the codes of the analysed cycles, at most 64, and predicts the energy of the nominal
    bed from them: from the record and the channel table, without knowledge of the actual
    instruments.
    """

    def __init__(
        self, condition: Condition, rig: Rig, size: Lengths, row: int, channel: ChannelInfo
    ) -> None:
        acquire = condition.acquire
        window = whole_cycles(
            size.samples, size.rate, condition.drive.frequency,
            filter_delay=channel.filter_delay, settle=acquire.settle, cycles=acquire.record,
        )  # fmt: skip
        self._window: Window = window.segments()[0]
        self._range = self._window.sample_range()
        self._condition, self._rig = condition, rig
        self._row, self._channel = row, channel
        self._codes: list[NDArray[np.int32]] = []

    def hear(self, block: Block) -> None:
        """Store the required samples of a block."""
        first, last = (int(np.clip(edge - block.start, 0, block.count)) for edge in self._range)
        if last > first:
            self._codes.append(block.codes[self._row, first:last].copy())

    def scalars(self) -> dict[str, float]:
        """Return `RECORDED_SCALARS`; 0 for beds that do not slide by design, nan if there is no
        such prediction.
        """
        bed_name = self._condition.scene.bed
        if bed_name not in BEDS_OF_ROWS:
            return dict.fromkeys(RECORDED_SCALARS, 0.0 if bed_name in STILL else float("nan"))
        window, channel = self._window, self._channel
        volts = np.concatenate(self._codes).astype(np.float64) * channel.scale + channel.offset
        acceleration = on_grid(volts / channel.sensitivity, self._range[0], window)
        step = 1.0 / (self._condition.drive.frequency * window.grid.points)
        # The certified poles are removed: the rows need the acceleration of the box, not of the
        # sensor.
        for pole in channel.time_constants:
            acceleration = without_pole(acceleration, pole, step)
        bed = rows_of(self._condition.scene, self._rig, nominal(self._condition.scene, self._rig))
        band, points = np.repeat(bed.threshold, bed.clearance.shape[1]), window.grid.points
        own = RAMP[self._condition.drive.mode]
        found = (
            bed.row_mass
            / window.cycles
            * np.array(
                [
                    sampled_energy(
                        band,
                        bed.clearance.ravel(),
                        bed.restitution,
                        acceleration - acceleration.mean(),
                        step,
                        SETTLE * points,
                        ramp * points,
                    )
                    for ramp in sorted(RAMP.values(), key=lambda ramp: ramp != own)
                ]
            )
        )
        total = found.sum(axis=1)
        numbers = (total[0], found[0, 0], abs(total[1] - total[0]) / np.sqrt(12.0))
        return dict(zip(RECORDED_SCALARS, map(float, numbers), strict=True))
