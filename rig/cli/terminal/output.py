"""What commands share: results on the terminal or as JSON, and the processors they may use."""

import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from daq.strange_text import json_text, visible
from rig.cli.terminal.tables import print_report, terminal

if TYPE_CHECKING:
    from analysis.results.report import Report


def print_json(value: Any) -> None:
    """JSON on standard output, nothing else; as much of it as is read."""
    with suppress(BrokenPipeError):
        print(json_text(value))


def say(sentence: str, to_stderr: bool = False) -> None:
    """Print one line; what it quotes of a stranger's cannot begin another, or steer the terminal."""
    print(visible(sentence), file=sys.stderr if to_stderr else sys.stdout)


def say_compiling() -> None:
    """Say on standard error what the wait is for; nobody may be there to hear it."""
    with suppress(OSError, ValueError):
        print("compiling for this processor, once: half a minute to a minute", file=sys.stderr, flush=True)


def print_result(report: "Report", folder: Path) -> None:
    """The verdict table of a report, and where its page lies."""
    console = terminal()
    print_report(console, report)
    console.print(f"report: {folder / 'report.html'}", highlight=False, soft_wrap=True)


def cores() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
