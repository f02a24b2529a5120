"""The prediction on the waveform that was recorded, beside the one on an ideal sine of the same
fundamental.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from analysis.results.run import RunEnergy
from analysis.uncertainty.budget import combine, difference_parts, refills_line
from analysis.uncertainty.budget_line import Line
from analysis.uncertainty.estimate import Estimate

__all__ = ["Recorded", "on_recorded"]

NUMERICS = 5e-3  # relative standard uncertainty: rows without a period, averaged over the recorded cycles (tests)
EXPONENT = 2.5  # dlnW_T/dlna where no prediction on a sine tells it: between 2 and 4, acts on u of the acceleration only


@dataclass(frozen=True, eq=False)
class Recorded:
    """W_T: mean over the runs of W_T on each one's waveform; difference: W_exp - W_T. J per cycle.
    lines: the budget, c_T being the derivatives of this W_T. pairs: (W_exp, W_T) of each run."""

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
    """The recorded waveforms' W_T of a condition with a mean W (J per cycle); None where it is not
    known of every run.

    lines: of W_exp. The waveform is read with the accelerometer, so that its scale error moves this
    W_T as it moves the one on a sine. refills: energies of poured beds over the nominal one's,
    which this W_T is of as well.
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
    # what a bed went through before is much the same in every run: no root of their number
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
