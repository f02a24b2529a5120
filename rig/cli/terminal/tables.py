"""Plain tables and numbers for the terminal: readable at 80 columns and without colour, never cut
in a pipe.
"""

import os
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from daq.strange_text import visible

if TYPE_CHECKING:
    from analysis.results.report import Report

PIPE_WIDTH = 200
"""Width where no window sets one: in a pipe or a log nothing is cut or wrapped."""

PLAIN = str.maketrans({"±": "+-", "²": "2", "∞": "inf"})
"""Replacements for characters that a terminal without UTF-8 lacks."""


MOST_ROWS = 40
"""Conditions of a session shown on the terminal; where there are more, a line says where to find
the others.
"""


class Terminal(Console):
    """The console of all commands: every string it prints, in sentences and in tables, is one line
    of plain text.

    Text from a foreign file is never markup, cannot steer the terminal and cannot begin a line of
    its own.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(markup=False, emoji=False, **options)

    def render_str(self, text: str, **options: Any) -> Text:
        """Return a string as rich's text; all strings pass through here before they are measured or
        printed.
        """
        return super().render_str(visible(text), **options)

    def on_broken_pipe(self) -> None:
        """Stop printing where the reader closed the pipe (`rig info DIR | head`); the command
        itself continues.
        """
        self.quiet = True
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self.file.fileno())
        os.close(nowhere)


def terminal(stderr: bool = False, quiet: bool = False) -> Console:
    """Return the console for results (standard output) or progress (standard error)."""
    console = Terminal(stderr=stderr, quiet=quiet)
    return (
        console if console.is_terminal else Terminal(stderr=stderr, quiet=quiet, width=PIPE_WIDTH)
    )


def millijoules(value: float | None, digits: int = 4) -> str:
    """Return an energy in mJ to `digits` digits, without an exponent from 0.0001 mJ up; a dash for
    None.
    """
    if value is None:
        return "-"
    scaled = 1e3 * value
    return f"{scaled:.{digits}g}" if abs(scaled) < 10.0**digits else f"{scaled:.0f}"


def number(value: Any, digits: int = 3) -> str:
    """Return a number to `digits` digits, a dash for None."""
    if value is None:
        return "-"
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    return f"{value:.{digits}g}"


def scaled(value: float | None, scale: float) -> str:
    """Return a number in another unit, a dash for None."""
    return "-" if value is None else f"{scale * value:g}"


def percent(value: float | None) -> str:
    """Return a fraction as a signed percentage, a dash for None."""
    return "-" if value is None else f"{100 * value:+.1f} %"


def table(
    title: str, columns: Sequence[str], rows: Iterable[Sequence[str]], left: Sequence[str] = ()
) -> Table:
    """Return a table with the columns named in `left` aligned left, all others right."""
    found = Table(title=title, title_justify="left", box=None, pad_edge=False)
    for column in columns:
        found.add_column(column, justify="left" if column in left else "right")
    for row in rows:
        found.add_row(*row)
    return found


def print_report(console: Console, report: "Report") -> None:
    """Print the verdict table of a run: a line per condition, claims, flags, the verdict, the agreement
    and the checks.
    """
    from analysis.report import report_sentences
    from analysis.report.deliberate_errors import deliberate_error_sentences
    from analysis.report.tables.fidelity import fidelity_sentences
    from analysis.text import counted

    rows = (
        (
            c.id,
            c.material,
            scaled(c.diameter, 1e3),
            c.bed,
            scaled(c.fill, 100),
            number(c.acceleration),
            millijoules(c.W_exp),
            millijoules(c.U_W_exp, 2),
            millijoules(c.W_T),
            percent(c.offset),
            number(c.E_n_truth, 2),
        )
        for c in report.conditions[:MOST_ROWS]
    )
    columns = ("id", "grains", "d", "bed", "fill", "a", "W_exp", "U", "W_T", "offset", "E_n truth")
    console.print(
        table(
            "Energies in mJ per cycle, fill in %, d in mm, a in m/s2",
            columns,
            rows,
            ("id", "grains", "bed"),
        )
    )
    more = len(report.conditions) - MOST_ROWS
    if more > 0:
        console.print(f"... and {counted(more, 'condition')} more, in report.csv and on the page")
    for claim in report.claims:
        console.print(f"claim, {claim.verdict}: {claim.claim.rstrip('.')} ({claim.why})")
    console.print()
    ideal = " (ideal waveform assumed in prescribed motion)" if report.waveform == "ideal" else ""
    tests = "no energy" if report_sentences.only_sweeps(report) else report.tests
    console.print(f"tests: {tests}; waveform: {report.waveform}{ideal}")
    for sentence in (*deliberate_error_sentences(report), *fidelity_sentences(report)):
        console.print()
        console.print(sentence, soft_wrap=True)
    for flag in report.flags:
        worst = "" if flag.worst is None else f", at worst {flag.worst:.2f} of the limit"
        console.print(f"warning: {flag.flag} in {counted(len(flag.runs), 'run')}{worst}")
    console.print(f"verdict: {report_sentences.verdict_line(report).lower()}")
    *told, _flags = report_sentences.found(report)
    for sentence in (
        *report_sentences.failures(report),
        report_sentences.headline(report),
        *told,
        *report_sentences.reasons(report),
    ):
        console.print(f"  {sentence.translate(PLAIN)}")
