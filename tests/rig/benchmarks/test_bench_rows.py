"""The comparison's own arithmetic: curves, exponents, failures, the file, the page."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from rig.benchmarks.machine import ROOT
from rig.benchmarks.methods import METHODS
from rig.benchmarks.methods.method import Failed, Method, Work
from rig.benchmarks.methods.ours import OURS
from rig.benchmarks.methods.rk4 import RK4
from rig.benchmarks.problems.conditions import conditions
from rig.benchmarks.problems.precision import precision
from rig.benchmarks.problems.sliders import Slider, weightless
from rig.benchmarks.problems.small_beds import (
    AVERAGE,
    SETTLE,
    by_rows,
    exact,
    followed,
    sliding,
    small_bed,
)
from rig.benchmarks.process import weighed_imports
from rig.benchmarks.results.claims import CLAIMS, checked, judged
from rig.benchmarks.results.curve import cost_at, exponent
from rig.benchmarks.results.fits import workers
from rig.benchmarks.results.page import FIGURES, JSONL, PAGE, as_line, page, read_rows
from rig.benchmarks.results.tables import break_even, number, tables
from rig.benchmarks.runner import Job, jobs, measured, rounded
from rig.benchmarks.timing import interleaved, ratios
from rig.cli.commands.bench import bench

DOCS = Path(__file__).parents[3] / "docs"


def stuck(slider: Slider, setting: float, *_: int) -> Work:
    raise Failed(f"{slider.name}: no end at {setting:g}")


def tiny() -> list[Job]:
    broken = Method("stuck", "compiled", "steps", (1.0,), (1.0,), stuck, order=1)
    return [
        Job("tiny", 1.0, lambda: precision(weightless(1.0), 2, True, (OURS, RK4, broken))),
        Job("broken", 1.0, lambda: exec("raise ValueError('out of order')")),  # type: ignore[func-returns-value]
    ]


def test_cost_is_interpolated_on_a_power_law() -> None:
    """error = n^-4, seconds = n: 1e-6 costs 10^1.5 exactly, between any two settings."""
    n = np.array([8.0, 64.0, 512.0])
    found = cost_at(1e-6, (n**-4.0).tolist(), n.tolist())
    assert found.reached
    assert found.seconds == pytest.approx(10**1.5, rel=1e-12)


def test_an_error_that_cancels_by_chance_does_not_count() -> None:
    assert cost_at(1e-3, [1e-1, 1e-9, 1e-2, 1e-4], [1.0, 2.0, 3.0, 4.0]).seconds > 3.0


def test_a_cost_that_is_not_reached_is_a_lower_bound() -> None:
    assert cost_at(1e-9, [1e-3, 1e-5], [1.0, 2.0]) == (2.0, False)


@pytest.mark.parametrize("power", [0.5, 1.0, 2.0])
def test_exponent_of_a_power_law(power: float) -> None:
    sizes = [10.0, 100.0, 1000.0]
    slope, error = exponent(sizes, [3.0 * s**power for s in sizes])
    assert slope == pytest.approx(power, abs=1e-12)
    assert error == pytest.approx(0.0, abs=1e-7)  # root of the round-off of a sum of squares


def test_error_of_an_exponent_covers_scatter() -> None:
    """1 % scatter over three decades: twice the stated error covers the truth in most of 200 draws
    (expected: 86 % for 3 degrees of freedom)."""
    rng = np.random.Generator(np.random.SFC64(7))
    sizes = np.logspace(1, 4, 5)
    hits = 0
    for _ in range(200):
        slope, error = exponent(sizes, sizes * np.exp(0.01 * rng.standard_normal(5)))
        hits += abs(slope - 1.0) <= 2.0 * error
    assert hits > 150


def test_calls_are_made_in_turn() -> None:
    calls: list[str] = []
    found = interleaved(
        {"a": lambda: calls.append("a"), "b": lambda: calls.append("b")}, 3, least=0.0
    )
    assert {name: len(times) for name, times in found.items()} == {"a": 3, "b": 3}
    assert "".join(calls[-6:]) == "abbaab"


def test_ratios_are_formed_round_by_round() -> None:
    assert ratios([2.0, 20.0, 6.0], [1.0, 10.0, 2.0]) == {
        "median": 2.0,
        "low": 2.0,
        "high": 3.0,
        "rounds": 3,
    }


def test_a_failing_method_keeps_its_row_and_a_failing_job_its_reason() -> None:
    rows = list(measured(tiny(), quick=True))
    assert [row["failure"] for row in rows if row.get("method") == "stuck"] == [
        "weightless, gap 1: no end at 1"
    ]
    assert [row["failure"] for row in rows if row["kind"] == "failed"] == [
        "ValueError: out of order"
    ]
    failed = next(table for table in tables(rows) if table.name == "failures")
    assert {line[1] for line in failed.lines} == {"stuck", "-"}


def test_claims_follow_from_the_rows() -> None:
    """Ours needs 1 us; RK4 falls with n^-4 and needs n us: at 1e-6 the ratio is 10^1.5, at 1e-9
    10^2.25.
    """
    ours = {
        "kind": "precision",
        "problem": "p",
        "method": OURS.name,
        "failure": None,
        "error": 1e-15,
        "us_each": [1.0],
    }
    theirs = [
        {**ours, "method": RK4.name, "error": n**-4.0, "us_each": [n]} for n in (8.0, 64.0, 512.0)
    ]  # fmt: skip
    found = [row for row in judged([ours, *theirs]) if row["problem"] == "all"]
    assert [row["ratio"]["median"] for row in found] == pytest.approx([10**1.5, 10**2.25], rel=1e-9)
    assert [(row["error"], row["demand"], row["held"]) for row in found] == [
        (1e-6, 2.0, True),
        (1e-9, 4.0, True),
    ]
    assert len(CLAIMS) == 4


def test_limits_are_judged_both_ways() -> None:
    spread = {"median": 199.0, "low": 190.0, "high": 210.0, "rounds": 3}
    rows = [
        {"kind": "fill", "method": "recording, 2 workers", "times_faster": spread},
        {"kind": "drift", "problem": "layers, 2 m/s2", "cycles": 10, "drift": 1e-12},
    ]
    assert [row["held"] for row in checked(rows)] == [False, True]


def test_workers_are_an_axis_with_a_speed_up() -> None:
    """Two processes that take 5/8 of the time: exponent log2(5/8), 1.6 times as fast, each round
    for itself.
    """
    found = workers({1: [8.0, 16.0, 4.0], 2: [5.0, 10.0, 2.0]})
    assert [row["size"] for row in found[:-1]] == [1, 2]
    fit = found[-1]
    assert fit["exponent"] == pytest.approx(np.log2(5.0 / 8.0), rel=1e-12)
    assert fit["speed_up"] == {"median": 1.6, "low": 1.6, "high": 2.0, "rounds": 3}
    assert fit["at_most_linear"] is None
    assert "2 processes are 1.60 times as fast as 1" in fit["what"]
    assert workers({1: [1.0]}) == []


def test_a_small_bed_is_the_same_by_other_integrators() -> None:
    """The bed against closed flights: round-off of fifteen rows. scipy's at rtol 1e-6: W to 1e-6."""
    bed = small_bed(5.0)
    true = exact(bed)
    assert len(sliding(bed)) == 15
    assert followed(bed) == pytest.approx(true, rel=1e-13)
    ivp = next(method for method in METHODS if method.name == "solve_ivp LSODA")
    fewer = replace(
        bed,
        stack=replace(
            bed.stack, threshold=bed.stack.threshold[:1], clearance=bed.stack.clearance[:1]
        ),
    )
    found = by_rows(fewer, lambda row: ivp.solve(row, 1e-6, SETTLE, AVERAGE).energy)
    assert found == pytest.approx(exact(fewer), rel=1e-6)


def test_bench_writes_rows_page_and_figures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A tiny problem through the command: the file reads back as the rows, the page is made from
    them alone.
    """
    assert bench(quick=True, out=tmp_path, as_json=False, todo=tiny()) == 0
    rows = read_rows(tmp_path / JSONL)
    assert rows[0]["kind"] == "machine"
    assert set(rows[0]) >= {"cpu", "cores", "python", "packages", "git_commit", "load"}
    assert (tmp_path / PAGE).read_text(encoding="utf-8") == page(rows)
    for suffix in ("svg", "png"):
        assert (tmp_path / FIGURES / f"precision.{suffix}").stat().st_size > 1000
    shown = capsys.readouterr()
    assert "weightless, gap 1" in shown.out
    assert "tiny" in shown.err


def test_json_prints_lines_and_nothing_else(capsys: pytest.CaptureFixture[str]) -> None:
    assert bench(quick=True, out=None, as_json=True, todo=tiny()[1:]) == 0
    rows = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [row["kind"] for row in rows] == ["machine", "failed"]


def test_an_interruption_keeps_the_rows_so_far(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted() -> list[dict[str, object]]:
        raise KeyboardInterrupt

    todo = [*tiny()[1:], Job("interrupted", 1.0, interrupted)]
    assert bench(quick=True, out=tmp_path, as_json=False, todo=todo) == 3
    assert [row["kind"] for row in read_rows(tmp_path / JSONL)] == ["machine", "failed"]
    assert "2 rows are in" in capsys.readouterr().err


def test_a_folder_that_cannot_be_written_is_bad_input(tmp_path: Path) -> None:
    from rig.cli import app

    (tmp_path / "file").write_text("")
    done = CliRunner().invoke(app.app, ["bench", "--quick", "--out", str(tmp_path / "file" / "x")])
    assert done.exit_code == 2


def test_rows_come_back_from_a_line() -> None:
    row = rounded({"a": 1.0 / 3.0, "b": [1e-17 / 3.0, None, True], "c": {"d": "é"}, "n": 12345678})
    assert json.loads(as_line(row)) == row
    assert row["a"] == 0.333333


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (None, "-"),
        (1234567.0, "1.2e+06"),
        (123.456, "123"),
        (0.0123, "0.0123"),
        (1e-9, "1.0e-09"),
    ],
)
def test_numbers_in_tables(value: float | None, text: str) -> None:
    assert number(value) == text


def test_the_shipped_jobs_are_complete() -> None:
    """Quick measures the same kinds of things, on fewer problems."""
    quick, full = ({job.title.partition(" ")[0] for job in jobs(which)} for which in (True, False))
    kinds = {
        "layers",
        "small",
        "drift",
        "chain",
        "acquisition",
        "recorder",
        "analysis",
        "fill",
        "scaling:",
    }
    assert kinds <= quick <= full


def test_the_performance_page_is_what_its_rows_give() -> None:
    """docs/performance.md is the output of `rig bench --out docs`: written by nobody's hand."""
    rows = read_rows(DOCS / JSONL)
    assert (DOCS / PAGE).read_text(encoding="utf-8") == page(rows)


def test_compiling_has_paid_when_what_it_took_is_saved() -> None:
    assert break_even(3.0, 1.0, 1001.0) == pytest.approx(
        3000.0
    )  # 1 ms saved a cycle: 3 s after 3000
    assert break_even(3.0, 2.0, 2.0) is None


def test_memory_is_that_of_the_process_and_not_of_the_one_that_started_it() -> None:
    """An interpreter that imports nothing needs some 10 MB; this one holds more, which a peak by
    getrusage inherits.
    """
    ballast = np.ones(60 * 2**20 // 8)
    small = weighed_imports((), ROOT)
    assert 1.0 < small < 50.0 < ballast.nbytes / 2**20
    assert weighed_imports(("numpy",), ROOT) > small


def test_the_axis_of_conditions_has_times_memory_and_an_exponent() -> None:
    """Of two small sessions; how cost grows is held by
    tests/analysis/comparison/test_many_conditions.py, by counting."""
    rows = conditions(1, True, (2, 4))
    assert [row["size"] for row in rows if row["kind"] == "scaling"] == [2, 4]
    assert [row["axis"] for row in rows if row["kind"] == "exponent"] == ["conditions"]
    assert all(row["writer_MB"] > 10.0 for row in rows if row["kind"] == "memory")
