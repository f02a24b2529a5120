"""How often a session fails: healthy rigs in at most 5 %, rigs with a mistake nearly always.

`PYTHONPATH=. python tests/road/test_verdict_family.py 400` prints how often, with the checks that failed.
"""

import sys
from collections import Counter
from typing import Any

import pytest
from memory_session import MemoryRecord, Plan
from scipy import stats

from analysis import read_session, run_energy

FAILING = 0.05
TEXT = """\
schema: rig/protocol/1
name: family
scene: {{{scene}}}
acquire: {{settle: {settle} cycles, record: 4 cycles}}
vary: {{{vary}}}
repeats: {repeats}
"""
LIGHT = "cavity: {length: 40 mm, width: 40 mm, height: 60 mm, wall: 2 mm}, grains: {diameter: 2 mm, fill: 30 %}"
ROWS = "layers: {rows: 4}"
THREE, FOUR = "drive.acceleration: [1, 3, 5]", "drive.acceleration: [2, 3, 4, 5]"
FILLS = f"scene.grains.fill: [0, 0.3, 0.85, 1], {FOUR}"
BEDS = f"scene.bed: [empty, locked], {THREE}"


def text(scene: str, vary: str, repeats: int = 4, settle: int = 4) -> str:
    return TEXT.format(scene=scene, vary=vary, repeats=repeats, settle=settle)


HEALTHY = {
    "light box": text(LIGHT, BEDS),
    "light box, once": text(LIGHT, BEDS, 1),
    "light box, twice": text(LIGHT, BEDS, 2),
    "light box, eight times": text(LIGHT, BEDS, 8),
    "no losses": text(f"losses: [], {ROWS}", FILLS),
    "fills": text(ROWS, FILLS),
    "one condition": text("bed: locked", "drive.acceleration: [3]"),
    "two levels": text("", "scene.bed: [empty, locked], drive.acceleration: [1, 3]"),
    "nulls": text(
        "losses: [noise, air], dashpot: {c: 100 N s/m}", f"scene.bed: [empty, locked, dashpot], {FOUR}"
    ),
    "slug": text("bed: slug, axis: vertical, losses: [], slug: {restitution: 0}, " + LIGHT.replace("30 %", "10 %"),
                 "drive.acceleration: [0.8 g, 1.2 g, 3 g]"),
}  # fmt: skip


def judged(record: MemoryRecord) -> dict[str, Any]:
    return read_session(record, {run.name: run_energy(record, run) for run in record.runs})


def failures(plan: Plan, count: int, first: int = 1) -> tuple[int, Counter[str]]:
    """Sessions that fail, of so many seeds, and the checks behind it."""
    failed, checks = 0, Counter[str]()
    for seed in range(first, first + count):
        report = judged(plan.session(seed))
        failed += report["verdict"] == "fails"
        checks.update(sentence[:60] for sentence in report["failures"])
    return failed, checks


def allowed(count: int, chance: float) -> int:
    """The most failures of so many sessions that a true share of FAILING exceeds with less than this chance."""
    return int(stats.binom.ppf(1 - chance, count, FAILING))


def test_a_healthy_light_box_passes() -> None:
    failed, checks = failures(Plan.of(HEALTHY["light box, once"]), 40)
    assert failed <= allowed(40, 1e-3), checks


@pytest.mark.slow
@pytest.mark.parametrize("name", HEALTHY)
def test_healthy_rigs_pass_in_400_sessions(name: str) -> None:
    """At most 29 of 400: exceeded by a true share of 5 % with a chance of 2 %."""
    failed, checks = failures(Plan.of(HEALTHY[name]), 400)
    assert failed <= 29, checks


MISTAKES = ("{skew: 1}", "{pole: 0.5}")  # 12.6 and 5 mrad at 20 Hz


def found(mistake: str, count: int) -> int:
    """Sessions with a mistake that fail, of so many."""
    return failures(Plan.of(text(ROWS, BEDS, settle=10) + f"mistake: {mistake}\n"), count)[0]


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_found(mistake: str) -> None:
    assert found(mistake, 4) == 4


@pytest.mark.slow
@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_found_in_95_of_100_sessions(mistake: str) -> None:
    assert found(mistake, 100) >= 95


def main(count: int, names: list[str]) -> None:
    for name in names or HEALTHY:
        failed, checks = failures(Plan.of(HEALTHY[name]), count)
        print(f"{name}: {failed} of {count} fail {dict(checks)}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2:])
