"""Rows of the report about a deliberate error."""

from dataclasses import dataclass

__all__ = ["DeliberateErrorReport", "DeliberateErrorRow"]


@dataclass(frozen=True, slots=True)
class DeliberateErrorRow:
    """The effect of a deliberate error on one condition; energies in J per cycle.

    W_true : the ledger's, over the same cycles; the bed's alone where friction was read as the
        bed's; None without truth
    error : W_exp/W_true - 1
    predicted : the same by the rule, from W_true, the apparent mass and the level
    ratio : error over predicted; None, as both, where no energy was dissipated
    """

    id: str
    W_exp: float
    W_true: float | None
    eta: float | None
    error: float | None
    predicted: float | None
    ratio: float | None


@dataclass(frozen=True, slots=True)
class DeliberateErrorReport:
    """The report's `deliberate_error`: the error that was made on purpose, and its effect on each
    condition.
    """

    kind: str
    parameter: float
    what: str
    rule: str
    notice: str
    conditions: tuple[DeliberateErrorRow, ...]
