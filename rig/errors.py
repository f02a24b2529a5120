"""Invalid input: what was found, what is allowed, and where, for every mistake at once."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable
from dataclasses import dataclass

from daq.strange_text import visible

LONGEST_QUOTE = 60
MOST_MISTAKES = 50


@dataclass(frozen=True)
class Mistake:
    """One mistake in the user's input.

    where : `file:line` or the command-line option, may be empty
    field : full path of the key, may be empty
    found, allowed : phrases
    hint : a complete question or piece of advice, such as "did you mean 'fill'?"
    """

    where: str
    field: str
    found: str
    allowed: str
    hint: str = ""

    def __str__(self) -> str:
        place = "".join(f"{part}: " for part in (self.where, self.field) if part)
        advice = f"; {self.hint}" if self.hint else ""
        return visible(f"{place}found {self.found}; allowed: {self.allowed}{advice}")


class InputError(Exception):
    """Input that cannot be used. `mistakes` lists everything that is wrong with it; str() has one
    line for each.
    """

    def __init__(self, *mistakes: Mistake) -> None:
        super().__init__(*mistakes)
        self.mistakes: tuple[Mistake, ...] = mistakes

    def __str__(self) -> str:
        return "\n".join(str(mistake) for mistake in self.mistakes)


def quote(value: object) -> str:
    """Return a user's value for a message: shortened, control characters escaped."""
    text = repr(value)
    return text if len(text) <= LONGEST_QUOTE else f"{text[: LONGEST_QUOTE - 3]}..."


def nearest(word: str, choices: Iterable[str]) -> str:
    """Return the hint "did you mean ...?" for a misspelt word, or "" if no choice is near."""
    close = difflib.get_close_matches(word[:LONGEST_QUOTE], list(choices), n=1, cutoff=0.6)
    return f"did you mean {close[0]!r}?" if close else ""


def in_order(mistakes: Iterable[Mistake]) -> list[Mistake]:
    """Return mistakes in the order of their lines: at most MOST_MISTAKES, plus one that counts the
    others.
    """
    ordered = sorted(mistakes, key=_line)
    more = len(ordered) - MOST_MISTAKES
    if more <= 0:
        return ordered
    return [*ordered[:MOST_MISTAKES], Mistake("", "", f"{more} more mistakes", "none")]


def _line(mistake: Mistake) -> float:
    """Return the line number of a mistake; infinity, the end of the list, if it has none."""
    number = mistake.where.rpartition(":")[2]
    return int(number) if number.isdecimal() else math.inf


class WorkerLost(Exception):
    """All workers were terminated from outside; the message names the runs in progress."""


class WorkerFailed(RuntimeError):
    """A program defect: the message contains the worker's traceback."""
