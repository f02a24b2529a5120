"""Displayed names of the losses outside the grains: by their law, because the paper's words for two
of them explain nothing.
"""

from analysis.report.tables.cells import significant
from analysis.results.report import Report
from analysis.results.session_rows import Span

__all__ = ["EXPLAINED", "first_principles", "loss_name", "losses_sentence"]

LAWS = {
    "noise": ("viscous", "sound that the box radiates"),
    "air": ("quadratic", "drag of the air on the box"),
}
"""Law of a loss by its name in the protocol, and the effect that the paper's word for it means."""

EXPLAINED = 1.0
"""Largest multiple of first principles at which the paper's word explains a loss: the estimate of
the drag is an upper limit already.
"""


def loss_name(name: str, report: Report) -> str:
    """Return the displayed name of a loss or cause, e.g. "unexplained viscous loss (the paper's
    noise)"; others unchanged.
    """
    if name not in LAWS:
        return name
    over = _over(name, report)
    unexplained = "unexplained " if over is None or (over.high or 0.0) > EXPLAINED else ""
    return f"{unexplained}{LAWS[name][0]} loss (the paper's {name})"


def short_name(name: str) -> str:
    """Return the law of a loss alone, for a narrow place; other names unchanged."""
    return LAWS[name][0] if name in LAWS else name


def first_principles(name: str, report: Report) -> str:
    """Return in words the size of a loss over its value by first principles; "" where that is not
    known.
    """
    over = _over(name, report)
    if over is None:
        return ""
    low, high = (_rounded(edge or 0.0) for edge in (over.low, over.high))
    times = low if low == high else f"{low} to {high}"
    return f"{times} times the {LAWS[name][1]} by first principles"


def losses_sentence(report: Report) -> str:
    """Return a sentence about the unexplained losses of the stand; "" for records and for a stand
    without.
    """
    if not report.synthetic:
        return ""
    losses = []
    for row in report.causes:
        name = row.cause
        if name in LAWS and row.in_run and loss_name(name, report).startswith("unexplained"):
            size = first_principles(name, report)
            losses.append(f"an {loss_name(name, report)}{f', {size}' if size else ''}")
    if not losses:
        return ""
    listed = "; and ".join(losses)
    return f"Between gauge and bed the stand has {listed}: coefficients that were put in and explain no offset."


def _over(name: str, report: Report) -> Span | None:
    """Return the range of a loss's size over its value by first principles; None where it is not
    known.
    """
    found = (row.over_first_principles for row in report.causes if row.cause == name)
    return next(found, None)


def _rounded(value: float) -> str:
    """Return three digits with spaces between thousands: 12 200, 317 000."""
    return (
        f"{float(f'{value:.3g}'):,.0f}".replace(",", " ")
        if value >= 1000
        else significant(value, 3)
    )
