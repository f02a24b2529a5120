"""The prediction on the recorded waveform, beside the one on an ideal sine of the same fundamental."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from analysis.results.run import RunEnergy
from analysis.uncertainty.budget import combine, difference_parts, refills_line
from analysis.uncertainty.budget_line import Line
from analysis.uncertainty.estimate import Estimate

__all__ = ["Recorded", "on_recorded"]

NUMERICS = 5e-3
"""Relative standard uncertainty of W_T averaged over the recorded cycles, for rows of grains without a
periodic motion (found by tests)."""
EXPONENT = 2.5
"""dlnW_T/dlna where no prediction on a sine gives it. It lies between 2 and 4 and only scales the
contribution of the accelerometer to u."""


@dataclass(frozen=True, eq=False)
class Recorded:
    """The prediction of a condition on its recorded waveforms; energies in J per cycle.

    W_T : mean over the runs, each on its own waveform
    difference : W_exp - W_T
    lines : the budget; its c_T are derivatives of this W_T
    pairs : (W_exp, W_T) of each run
    """

    W_T: Estimate
    difference: Estimate
    lines: tuple[Line, ...]
    pairs: tuple[tuple[float, float], ...]


def on_recorded(
    runs: Sequence[RunEnergy],
    W: float,
    lines: Sequence[Line],
    exponent: float | None,
    refills: Sequence[float] = (),
) -> Recorded | None:
    """Return W_T on the recorded waveforms of a condition; None where a run lacks it.

    W: mean of W_exp, J per cycle; lines: its budget; exponent: dlnW_T/dlna. The accelerometer
    recorded the waveform, so that its scale error changes this W_T as it changes the one on a sine.
    refills: energies of refilled beds over the nominal one's; this W_T too is that of the nominal
    bed.
    """
    known = [
        run.recorded for run in runs if run.recorded is not None and math.isfinite(run.recorded)
    ]
    if len(known) < len(runs):
        return None
    W_T = math.fsum(known) / len(known)
    pairs = tuple(zip((run.energy.W for run in runs), known, strict=True))
    n = EXPONENT if exponent is None else exponent
    own = [
        replace(
            line,
            c_T=n * W_T
            if line.source in ("acceleration sensitivity", "acceleration gain")
            else 0.0,
        )
        for line in lines
    ]
    # The history of the bed before the record is much the same in every run: its uncertainty does
    # not fall with the root of their number.
    history = math.fsum(run.u_recorded for run in runs) / len(runs)
    own.append(Line("history of the bed", "J", history, math.inf, 0.0, 1.0, shared=False))
    own.append(
        Line(
            "prediction numerics",
            "1",
            NUMERICS / math.sqrt(len(known)),
            math.inf,
            0.0,
            W_T,
            shared=False,
        )
    )
    own += refills_line(refills, W_T)
    return Recorded(
        W_T=combine(W_T, [(line.part_T, line.nu) for line in own]),
        difference=combine(W - W_T, difference_parts(own, pairs)),
        lines=tuple(own),
        pairs=pairs,
    )
