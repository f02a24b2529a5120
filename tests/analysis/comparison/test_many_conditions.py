"""What a report costs grows at most as the number of its conditions: calls and memory are counted,
nothing is timed.
"""

import dataclasses
import sys
import tracemalloc
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from analytic_record import NOMINAL, Bench, condition, dashpot_energy, prediction_for, session
from claim_data import entry

from analysis import RunEnergy, agreement, run_energy, write_report
from analysis.session.protocol import ExpectedClaim
from analysis.uncertainty.multiple_comparisons import beaten
from daq.documents.classes import built

BED, REPEATS = 300.0, 2


@cache
def measured() -> tuple[dict[str, RunEnergy], dict[str, Any], dict[str, Any]]:
    """Energies of a dozen conditions, the channel table and the conditions."""
    table = [
        condition(
            f"b{k}",
            fill=0.4 + 0.05 * k,
            acceleration_set=2.0 + 0.3 * k,
            settle_cycles=2,
            record_cycles=8,
        )
        for k in range(12)
    ]
    bench = Bench(
        channels=dict(NOMINAL),
        repeats=REPEATS,
        samples=11 * 512,
        noise=(1e-3, 1e-5),
        level_error=1e-3,
    )
    record = session(table, lambda one, _: BED * one["fill"], bench, np.random.default_rng(1))
    return (
        {run.name: run_energy(record, run) for run in record.runs},
        record.channels,
        record.conditions,
    )


def report_of(count: int, folder: Path) -> None:
    """A report of so many conditions, with a claim over all of them."""
    energies, channels, table = measured()
    kinds = list(table.values())
    conditions, runs = {}, []
    for k in range(count):
        kind, name = kinds[k % len(kinds)], f"c{k:05d}"
        fill = 0.3 + 0.6 * k / count
        conditions[name] = {
            **kind,
            "id": name,
            "fill": fill,
            "varied": {"scene.grains.fill": f"{fill:g}"},
        }
        runs += [
            dataclasses.replace(run, run=f"run_{REPEATS * k + run.repeat:06d}", condition=name)
            for run in energies.values()
            if run.condition == kind["id"]
        ]
    prediction = prediction_for(
        list(conditions.values()), lambda one, a: dashpot_energy(BED * one["fill"], a), 1e-3
    )
    claims = []
    for kind in ("optimum", "order", "rise", "nonlinear"):
        claim = entry(
            kind, values=("c00000", "c00001"), limits=(0.1,) if kind == "nonlinear" else ()
        )
        levels = [{"value": name, "conditions": [name]} for name in conditions]
        claims.append(built(ExpectedClaim, {**claim, "cases": [{"at": {}, "levels": levels}]}))
    write_report(
        agreement(runs, conditions, prediction, channels, synthetic=True, expect=claims), folder
    )


def calls(count: int, folder: Path) -> int:
    """Calls of functions, Python's and C's."""
    heard = [0]

    def hear(_frame: object, event: str, _: object) -> None:
        heard[0] += event in ("call", "c_call")

    sys.setprofile(hear)
    try:
        report_of(count, folder)
    finally:
        sys.setprofile(None)
    return heard[0]


def peak(count: int, folder: Path) -> int:
    """Peak memory in bytes."""
    tracemalloc.start()
    report_of(count, folder)
    found = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return found


@pytest.mark.parametrize(
    ("cost", "few"), [(calls, 30), pytest.param(peak, 300, marks=pytest.mark.slow)]
)
def test_calls_and_memory_grow_no_faster_than_conditions(
    cost: Callable[[int, Path], int], few: int, tmp_path: Path
) -> None:
    """(c(4n) - c(2n)) / (c(2n) - c(n)) is 2 for what is linear, whatever is constant, and 4 for
    what goes by pairs: at most 2.2, so that no more than a tenth goes by pairs (searches take some
    steps more or less)."""
    report_of(2, tmp_path)  # imports and tables that are made once
    one, two, four = (cost(times * few, tmp_path) for times in (1, 2, 4))
    assert four - two <= 2.2 * (two - one)


@pytest.mark.parametrize("spread", [1.0, 3.0, 30.0])
def test_comparisons_with_the_best_need_no_pairs(
    spread: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Means in groups of nearly the same scatter lead to the p values of all pairs. Of 300 standard
    deviations spread over a factor `spread`, 64 groups of neighbours hold a factor spread^(1/64)
    each: a t that is off by half of that, at a t of 5, moves ln p by no more than 5^2 ln(spread) /
    64."""
    rng = np.random.default_rng(7)
    s = np.exp(rng.uniform(0.0, np.log(spread), 300))
    means = [
        (float(s_i * x), float(s_i**2), 12.0)
        for s_i, x in zip(s, rng.normal(0.0, 1.0, 300), strict=True)
    ]
    found = np.array(beaten(means))
    monkeypatch.setattr("analysis.uncertainty.multiple_comparisons.GROUPS", len(means))
    exact = np.array(beaten(means))
    told = exact > 1e-5
    assert found[told] == pytest.approx(exact[told], rel=25 * np.log(spread) / 64 + 1e-9)
