"""What a hard case is, and how its numbers are written so that machines agree."""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

Rule = Literal["at most", "at least", "exactly"]


@dataclass(frozen=True)
class Measure:
    """One number of a case: what it is and against what it was taken, its value, and what is required of it.

    error : a small number that is round-off or a cut, of which only the size means anything
    """

    what: str
    value: float
    rule: Rule
    limit: float
    error: bool = False

    @property
    def held(self) -> bool:
        """Whether the value keeps its limit; not a number never does."""
        if self.rule == "at most":
            return self.value <= self.limit
        if self.rule == "at least":
            return self.value >= self.limit
        return self.value == self.limit

    @property
    def shown(self) -> str:
        """The value as the table has it: an error by the next power of ten, a number by two digits behind a "~"."""
        if self.rule == "exactly":
            return plain(self.value)
        return decade(self.value) if self.error else f"~{plain(float(f'{self.value:.2g}'))}"


def at_most(what: str, value: float, limit: float) -> Measure:
    """An error that must not exceed its limit."""
    return Measure(what, float(value), "at most", limit, error=True)


def no_more(what: str, value: float, limit: float) -> Measure:
    """A count or a share that must not exceed its limit."""
    return Measure(what, float(value), "at most", limit)


def at_least(what: str, value: float, limit: float) -> Measure:
    """A size that must reach its limit: what a naive method gets wrong, mostly."""
    return Measure(what, float(value), "at least", limit)


def exactly(what: str, value: float, expected: float) -> Measure:
    """A count or a value that must be met to the last bit."""
    return Measure(what, float(value), "exactly", expected)


def plain(value: float) -> str:
    """A number without padding: 1e-9, 512, 0.044."""
    return re.sub(r"e([+-])0*(\d)", lambda m: f"e{m[1].strip('+')}{m[2]}", f"{value:g}")


def decade(value: float) -> str:
    """The next power of ten above a value: what round-off leaves differs between machines within a decade."""
    if not math.isfinite(value):
        return "not finite"
    return "0" if value <= 0.0 else f"below 1e{math.floor(math.log10(value)) + 1:d}"


@dataclass(frozen=True)
class Outcome:
    """What a case gave.

    measured : what is required of this project's code
    naive : the failure itself, shown with the method that falls for it; empty where showing it is not cheap
    """

    measured: tuple[Measure, ...]
    naive: tuple[Measure, ...] = field(default=())

    @property
    def held(self) -> bool:
        """Whether everything required was met and the failure was really provoked."""
        return bool(self.measured) and all(measure.held for measure in (*self.measured, *self.naive))


@dataclass(frozen=True)
class Case:
    """A hard case: the failure that it provokes, the behaviour required, and the function that measures it."""

    name: str
    provokes: str
    required: str
    run: Callable[[], Outcome]
