"""Output shared by the commands: results as tables or JSON, and the number of processors."""

import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from daq.json_text import json_text
from daq.strange_text import visible
from rig.cli.terminal.tables import print_report, terminal

if TYPE_CHECKING:
    from analysis.results.report import Report


def print_json(value: Any) -> None:
    """Print JSON and nothing else to standard output; stop quietly where the reader closes it."""
    with suppress(BrokenPipeError):
        print(json_text(value))


def say(sentence: str, to_stderr: bool = False) -> None:
    """Print one line; text that it quotes cannot begin another line or steer the terminal."""
    print(visible(sentence), file=sys.stderr if to_stderr else sys.stdout)


def say_compiling() -> None:
    """Print the reason of the wait to standard error, which may be closed."""
    with suppress(OSError, ValueError):
        print(
            "compiling for this processor, once: half a minute to a minute",
            file=sys.stderr,
            flush=True,
        )


def print_result(report: "Report", folder: Path) -> None:
    """Print the verdict table of a report, and the path of its page."""
    console = terminal()
    print_report(console, report)
    console.print(f"report: {folder / 'report.html'}", highlight=False, soft_wrap=True)


def cores() -> int:
    """Return the number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
