"""True energies of a simulated run: means of its ledger over the drive cycles that are analysed."""

import math
from collections.abc import Sequence

import numpy as np

from analysis.session.ledger_columns import EXACT
from analysis.session.record import RunFacts, Truth
from analysis.session.setting import Setting
from analysis.signals.cycles import Window

__all__ = ["ledger_means"]

CLOSURES = ("closure", "closure_exciter")  # columns whose largest magnitude counts, not the mean
PIECE = 4096  # cycles of a ledger that are read at a time, so that memory does not grow with it


def ledger_means(
    truth: Truth | None,
    run: RunFacts,
    setting: Setting,
    window: Window,
    stretches: Sequence[Window],
) -> dict[str, float] | None:
    """Return the true energies, means over the analysed drive cycles, and the largest closure
    errors.

    None for a record without truth, or with gaps in its ledger.
    """
    if truth is None:
        return None
    first, period = round(setting.settle_cycles), window.grid.period
    read = [(round((part.start - window.start) / period), part.cycles) for part in stretches]
    closure: dict[str, float] = {}
    count, total = 0, np.zeros(1)
    for begin, cycles in read:
        for place in range(begin, begin + cycles, PIECE):
            end = min(place + PIECE, begin + cycles)
            columns, rows = truth.ledger(run.name, first + place, first + end)
            if len(rows) < end - place:
                return None
            total = total + rows.sum(axis=0)
            count += len(rows)
            for name in CLOSURES:
                if name in columns:
                    own = float(np.abs(rows[:, columns.index(name)]).max())
                    closure[name] = max(own, closure.get(name, 0.0))
    found = dict(zip(columns, (total / count).tolist(), strict=True))
    known = {name: value for name, value in found.items() if not math.isnan(value)}
    return known | closure if known.keys() >= found.keys() - {EXACT} else None
