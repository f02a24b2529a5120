"""Where a waveform crosses a level: the region after the last crossing of a peak is the one below
it.
"""

import numpy as np
import pytest

from rig.kernels.waveform import crossings, extrema, motion


@pytest.mark.parametrize("ulps", range(-40, 41, 4))
@pytest.mark.parametrize("angle", np.linspace(0.0, 2.0 * np.pi, 13))
def test_a_level_that_is_just_reached_is_left_again(ulps: int, angle: float) -> None:
    """Bands within 40 units in the last place of the peak: between the two peaks the acceleration
    is inside the band, so every line of the table that does not sit at a peak, to the width sqrt(2
    x 40 eps) of the cap cut off there, has region 0."""
    P, Q = np.array([np.cos(angle), 0.0, 0.01]), np.array([np.sin(angle), 0.02, 0.0])
    turning = extrema(P, Q)
    peaks = [motion(phase, P, Q)[2] for phase in turning]
    for peak in (max(peaks), -min(peaks)):
        band = peak * (1.0 + ulps * np.finfo(float).eps)
        found = crossings(np.array([band]), P, Q, turning)
        lines = found.tables[0][: found.counts[0] + 1]
        assert (np.diff(lines[:, 0]) >= 0.0).all()
        for phase, after in zip(lines[:, 0], lines[:, 3], strict=True):
            ends = lines[:, 0][lines[:, 0] > phase]
            middle = 0.5 * (phase + (ends[0] if ends.size else 2.0 * np.pi))
            a = motion(middle, P, Q)[2]
            if abs(abs(a) - band) > 1e-12:
                last = lines[lines[:, 0] == phase][-1]
                assert last[3] == (1.0 if a > band else -1.0 if a < -band else 0.0), (
                    after,
                    a,
                    band,
                )
