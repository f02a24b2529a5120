"""What the report says of a deliberately bad experiment."""

from dataclasses import dataclass

__all__ = ["MistakeReport", "MistakeRow"]


@dataclass(frozen=True, slots=True)
class MistakeRow:
    """How wrong a condition came out. W_exp, W_true (the ledger's, over the same cycles; the bed's
    alone where friction was taken for damping): J per cycle; error = W_exp/W_true - 1; predicted by
    the rule, from W_true, the apparent mass and the level; ratio of both. None where the record
    holds no truth or nothing was dissipated."""

    id: str
    W_exp: float
    W_true: float | None
    eta: float | None
    error: float | None
    predicted: float | None
    ratio: float | None


@dataclass(frozen=True, slots=True)
class MistakeReport:
    """The report's `deliberate_error`: what was done wrong on purpose, and how wrong it made each
    condition.
    """

    kind: str
    parameter: float
    what: str
    rule: str
    notice: str
    conditions: tuple[MistakeRow, ...]
