"""What the terminal shows: help that teaches by example, tables and views that fit 80 columns and
need no colour.
"""

import io
import re
import shlex
from collections.abc import Iterator

import pytest
import typer
from bare_rows import bare
from rich.console import Console

from analysis.results.condition_row import ConditionRow
from analysis.results.report import Report
from analysis.results.session_rows import AgreementRow
from rig.cli.app import app
from rig.cli.terminal import progress as progress_module
from rig.cli.terminal.live import ConditionLine, LiveView
from rig.cli.terminal.progress import progress
from rig.cli.terminal.tables import print_report, table

GROUP = typer.main.get_command(app)
COMMANDS = sorted(GROUP.commands)  # type: ignore[attr-defined]
COLOUR = re.compile(r"\x1b\[[0-9;]*(3[0-7]|4[0-7]|38;|48;|9[0-7])m")
WIDTH = 80


@pytest.mark.parametrize("name", COMMANDS)
def test_help_teaches_by_an_example_that_parses(name: str) -> None:
    command = GROUP.commands[name]  # type: ignore[attr-defined]
    examples = re.findall(r"Example: (rig .+)", command.help)
    assert examples
    for example in examples:
        words = shlex.split(example)
        assert words[:2] == ["rig", name]
        command.make_context(name, words[2:])
    assert all(
        option.help
        for option in command.params
        if getattr(option, "opts", [""])[0].startswith("--")
    )


def on_terminal(colour: bool = False) -> Console:
    return Console(
        file=io.StringIO(),
        width=WIDTH,
        force_terminal=True,
        no_color=not colour,
        legacy_windows=False,
    )


def lines_of(console: Console) -> Iterator[str]:
    assert isinstance(console.file, io.StringIO)
    text = console.file.getvalue()
    assert COLOUR.search(text) is None
    return (re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", line) for line in text.splitlines())


def test_the_live_view_fits_and_needs_no_colour() -> None:
    console = on_terminal()
    view = LiveView(
        {f"c{n:03d}": ConditionLine("dashpot", 0.875, 0.0125, 9.75, 100) for n in range(40)},
        console,
    )
    view._sums = {f"c{n:03d}": [0.0123456] * 100 for n in range(40)}
    view._flags = {f"c{n:03d}": {"overload_hi", "over_peak"} for n in range(40)}
    console.print(view)
    shown = list(lines_of(console))
    assert max(map(len, shown)) <= WIDTH
    assert not any("…" in line for line in shown)
    assert any("c039" in line and "100/100" in line and "0.0123 J" in line for line in shown)


REPORT = bare(
    Report,
    conditions=tuple(
        bare(
            ConditionRow,
            id=f"c{n:03d}",
            material="stainless",
            diameter=0.0125,
            bed="dashpot",
            fill=0.875,
            acceleration=9.987654,
            W_exp=1.2345678,
            U_W_exp=0.123456,
            W_T=1.1234567,
            offset=-0.1234,
            E_n_truth=-0.987,
        )
        for n in range(3)
    ),
    claims=(),
    nulls=(),
    references=(),
    flags=(),
    failures=(),
    left_out=(),
    sweeps=(),
    comparisons=(),
    causes=(),
    agreement=bare(
        AgreementRow, ratio=1.0789, U_ratio=0.0123, k=2.0, put_in=0.05, mean_offset=0.07, n=3
    ),
    waveform="ideal",
    tests="measurement",
    verdict="passes",
    reasons=("short",),
    synthetic=True,
)


def test_the_final_table_fits_with_every_number_whole() -> None:
    console = on_terminal()
    print_report(console, REPORT)
    shown = [line.rstrip() for line in lines_of(console)]
    assert max(map(len, shown)) <= WIDTH
    (row,) = [line for line in shown if line.startswith("c001")]
    assert (
        " ".join(row.split()) == "c001 stainless 12.5 dashpot 87.5 9.99 1235 123 1123 -12.3 % -0.99"
    )


def test_a_wide_table_wraps_and_cuts_nothing() -> None:
    console = on_terminal()
    words = "a sentence that goes on for longer than any column of a terminal would have room for"
    console.print(
        table("", ("name", "source", "why"), [("x", words, words)], ("name", "source", "why"))
    )
    shown = list(lines_of(console))
    assert max(map(len, shown)) <= WIDTH
    assert sorted(" ".join(shown[1:]).split()) == sorted(f"x {words} {words}".split())


def test_progress_prints_a_line_for_every_tenth_without_a_terminal(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with progress("runs") as watch:
        for done in range(1, 41):
            watch(done, 40)
    assert capsys.readouterr().err.splitlines() == [
        f"{done} of 40 runs" for done in range(4, 41, 4)
    ]
    with progress("runs", quiet=True) as watch:
        watch(1, 1)
    assert capsys.readouterr().err == ""


def test_progress_has_a_bar_and_the_time_left_on_a_terminal(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    console = on_terminal()
    monkeypatch.setattr(progress_module, "terminal", lambda **_: console)
    with progress("runs") as watch:
        for done in range(1, 6):
            watch(done, 5)
    shown = list(lines_of(console))
    assert max(map(len, shown)) <= WIDTH
    assert any("5/5" in line and "left" in line for line in shown)
