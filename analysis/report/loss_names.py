"""What the losses outside the grains are called: by their law. The paper's words for two of them
explain nothing.
"""

from analysis.report.tables.cells import significant
from analysis.results.report import Report
from analysis.results.session_rows import Span

__all__ = ["EXPLAINED", "first_principles", "loss_name", "losses_sentence"]

LAWS = {
    "noise": ("viscous", "sound that the box radiates"),
    "air": ("quadratic", "drag of the air on the box"),
}
"""Law of a loss by its name in the protocol, and what the paper's word for it would be by first
principles.
"""

EXPLAINED = 1.0
"""Times first principles up to which the paper's word may explain a loss: the drag is a ceiling
already.
"""


def loss_name(name: str, report: Report) -> str:
    """A loss or cause as it is displayed, e.g. "unexplained viscous loss (the paper's noise)";
    others as they are.
    """
    if name not in LAWS:
        return name
    over = _over(name, report)
    unexplained = "unexplained " if over is None or (over.high or 0.0) > EXPLAINED else ""
    return f"{unexplained}{LAWS[name][0]} loss (the paper's {name})"


def short_name(name: str) -> str:
    """The same for a narrow place: the law alone."""
    return LAWS[name][0] if name in LAWS else name


def first_principles(name: str, report: Report) -> str:
    """How large a loss is beside what its word in the paper would be, "" where nobody computed it."""
    over = _over(name, report)
    if over is None:
        return ""
    low, high = (_rounded(edge or 0.0) for edge in (over.low, over.high))
    times = low if low == high else f"{low} to {high}"
    return f"{times} times the {LAWS[name][1]} by first principles"


def losses_sentence(report: Report) -> str:
    """What the stand loses outside the grains and nobody has explained; "" for records and for a
    stand without.
    """
    if not report.synthetic:
        return ""
    told = []
    for row in report.causes:
        name = row.cause
        if name in LAWS and row.in_run and loss_name(name, report).startswith("unexplained"):
            size = first_principles(name, report)
            told.append(f"an {loss_name(name, report)}{f', {size}' if size else ''}")
    if not told:
        return ""
    listed = "; and ".join(told)
    return f"Between gauge and bed the stand has {listed}: coefficients that were put in and explain no offset."


def _over(name: str, report: Report) -> Span | None:
    found = (row.over_first_principles for row in report.causes if row.cause == name)
    return next(found, None)


def _rounded(value: float) -> str:
    """Three digits, thousands apart: 12 200, 317 000."""
    return (
        f"{float(f'{value:.3g}'):,.0f}".replace(",", " ")
        if value >= 1000
        else significant(value, 3)
    )
