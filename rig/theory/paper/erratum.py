"""One line of the errata."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Erratum:
    """A statement of the paper, as printed and corrected, with a number of each.

    equation : where in the paper; subject : what the numbers are; printed, corrected : both forms in words
    printed_value, corrected_value : in `unit`, None where the printed form gives no number
    holds : whether the statement holds as printed; note : what else there is to say
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
