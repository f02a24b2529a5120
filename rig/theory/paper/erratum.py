"""One entry of the errata."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Erratum:
    """A statement of the paper, as printed and corrected, each with a number.

    equation : its place in the paper
    subject : the quantity that the numbers give
    printed, corrected : both forms in words
    printed_value, corrected_value : in `unit`, None if the printed form gives no number
    holds : whether the statement holds as printed
    note : further remarks
    """

    equation: str
    subject: str
    printed: str
    corrected: str
    printed_value: float | None
    corrected_value: float | None
    unit: str
    holds: bool
    note: str = ""
