"""The evaluation of every condition by itself, which processes may share."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from analysis.comparison.offset_terms import Actual, offset_terms
from analysis.comparison.refills import RefillColumns, refill_columns
from analysis.results.condition import Result, evaluate
from analysis.results.condition_row import OffsetTerms
from analysis.results.run import RunEnergy
from analysis.session.prediction_entry import PredictionEntry
from analysis.session.record import ChannelFacts
from analysis.session.setting import Setting
from analysis.shared_work import ForEach

__all__ = ["Evaluated", "evaluated"]


@dataclass(frozen=True, slots=True)
class Evaluated:
    """A condition evaluated.

    result : mean over its runs, uncertainty, and the prediction at its level
    refills : its columns about refills
    terms : of its offset; None where they are not known
    """

    result: Result
    refills: RefillColumns
    terms: OffsetTerms | None


def evaluated(
    settings: Sequence[Setting],
    runs: Mapping[str, Sequence[RunEnergy]],
    entries: Mapping[str, PredictionEntry],
    channels: Mapping[str, ChannelFacts],
    actual: Actual | None,
    each: ForEach,
) -> list[Evaluated]:
    """Return the evaluations of conditions, in their order.

    settings: of conditions that have runs; runs, entries: by the conditions' ids; actual: see
    `analysis.comparison.offset_terms`; each: applies a function to every setting.
    """

    def one(setting: Setting) -> Evaluated:
        own, entry = runs[setting.id], entries.get(setting.id)
        result = evaluate(setting, own, entry, channels)
        terms = offset_terms(result, entry, channels, actual)
        # Without the runs: another process would send them back to where they came from.
        return Evaluated(replace(result, runs=()), refill_columns(result), terms)

    return [
        replace(found, result=replace(found.result, runs=tuple(runs[setting.id])))
        for setting, found in zip(settings, each(one, settings), strict=True)
    ]
