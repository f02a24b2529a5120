"""A hard case, and the form of its numbers on which machines agree."""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

Rule = Literal["at most", "at least", "exactly"]


@dataclass(frozen=True)
class Measure:
    """One number of a case: its name and reference, its value, and the requirement.

    error: a small number from round-off or a cut-off, of which only the order of magnitude is
    meaningful
    """

    what: str
    value: float
    rule: Rule
    limit: float
    error: bool = False

    @property
    def held(self) -> bool:
        """Whether the value keeps its limit; NaN never does."""
        if self.rule == "at most":
            return self.value <= self.limit
        if self.rule == "at least":
            return self.value >= self.limit
        return self.value == self.limit

    @property
    def shown(self) -> str:
        """The value for the table: an error as the next power of ten, another number with two
        digits after a "~".
        """
        if self.rule == "exactly":
            return plain(self.value)
        return decade(self.value) if self.error else f"~{plain(float(f'{self.value:.2g}'))}"


def at_most(what: str, value: float, limit: float) -> Measure:
    """Return an error that must not exceed its limit."""
    return Measure(what, float(value), "at most", limit, error=True)


def no_more(what: str, value: float, limit: float) -> Measure:
    """Return a count or a fraction that must not exceed its limit."""
    return Measure(what, float(value), "at most", limit)


def at_least(what: str, value: float, limit: float) -> Measure:
    """Return a size that must reach its limit, usually one that a naive method gets wrong."""
    return Measure(what, float(value), "at least", limit)


def exactly(what: str, value: float, expected: float) -> Measure:
    """Return a count or a value that must be equal to the last bit."""
    return Measure(what, float(value), "exactly", expected)


def plain(value: float) -> str:
    """Return a number without padding: 1e-9, 512, 0.044."""
    return re.sub(r"e([+-])0*(\d)", lambda m: f"e{m[1].strip('+')}{m[2]}", f"{value:g}")


def decade(value: float) -> str:
    """Return the next power of ten above a value: round-off differs between machines within a
    decade.
    """
    if not math.isfinite(value):
        return "not finite"
    return "0" if value <= 0.0 else f"below 1e{math.floor(math.log10(value)) + 1:d}"


@dataclass(frozen=True)
class CaseOutcome:
    """The measured numbers of a case.

    measured: requirements on this project's code. naive: the failure itself, shown by a method that
    suffers it; empty where that is not cheap.
    """

    measured: tuple[Measure, ...]
    naive: tuple[Measure, ...] = field(default=())

    @property
    def held(self) -> bool:
        """Whether all requirements are met and the failure was really provoked."""
        return bool(self.measured) and all(
            measure.held for measure in (*self.measured, *self.naive)
        )


@dataclass(frozen=True)
class Case:
    """A hard case: the failure that it provokes, the required behaviour, and the function that
    measures it.
    """

    name: str
    provokes: str
    required: str
    run: Callable[[], CaseOutcome]
