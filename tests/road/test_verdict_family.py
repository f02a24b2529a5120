"""How often a session fails: healthy rigs in at most 5 %, rigs with a fault in at least 95 %.

`PYTHONPATH=.:tests/road python tests/road/test_verdict_family.py 400` prints both for every case,
or for those named after the number; with the checks that failed.
"""

import math
import sys
from collections import Counter
from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import pytest
from memory_session import MemoryRecord, Plan
from scipy import stats

from analysis import read_session
from daq.chain.channel import ChannelInfo

FAILING, FOUND = 0.05, 0.95
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
SHORT = ("acquire.settle=4 cycles", "acquire.record=4 cycles")
NULL = ("scene.bed=[empty, locked]", "drive.acceleration=[1, 2, 3]")


@dataclass(frozen=True)
class Case:
    """A protocol: its text, its name among the shipped ones, or its file, with changes. seeds:
    sessions of the slow test (400, or fewer where a session takes many seconds)."""

    protocol: str
    sets: tuple[str, ...] = ()
    varies: tuple[str, ...] = ()
    seeds: int = 400

    def plan(self) -> Plan:
        return Plan.of(self.protocol, self.sets, self.varies)


def made(scene: str, vary: str, repeats: int = 4, settle: int = 4) -> Case:
    return Case(TEXT.format(scene=scene, vary=vary, repeats=repeats, settle=settle))


HEALTHY = {
    "light box": made(LIGHT, BEDS),
    "light box, once": made(LIGHT, BEDS, 1),
    "light box, twice": made(LIGHT, BEDS, 2),
    "light box, eight times": made(LIGHT, BEDS, 8),
    "no losses": made(f"losses: [], {ROWS}", FILLS),
    "fills": made(ROWS, FILLS),
    "one condition": made("bed: locked", "drive.acceleration: [3]"),
    "two levels": made("", "scene.bed: [empty, locked], drive.acceleration: [1, 3]"),
    "dashpot": made(
        "losses: [noise, air], dashpot: {c: 100 N s/m}",
        f"scene.bed: [empty, locked, dashpot], {FOUR}",
    ),
    "single_mass": made(
        "bed: single_mass, axis: vertical, losses: [], single_mass: {restitution: 0}, "
        + LIGHT.replace("30 %", "10 %"),
        "drive.acceleration: [0.8 g, 1.2 g, 3 g]",
    ),
    "guide": made("losses: [noise, mount], support: guide", BEDS, 2),
    "cords": made("losses: [mount], support: cords, axis: vertical, " + LIGHT, BEDS, 2),
    "fill_rate, four fills": Case("fill_rate", varies=("scene.grains.fill=[0, 0.3, 0.85, 1]",)),
    "fill_rate": Case("fill_rate", SHORT),
    "fill_rate, no losses": Case("fill_rate", (*SHORT, "scene.losses=[]")),
    "density": Case("density", SHORT),
    "size": Case("size", SHORT),
    "acceleration": Case("acceleration", SHORT),
    "frequency": Case("frequency", SHORT),
    "nulls": Case("nulls", SHORT),
    "single_mass_vertical": Case("single_mass_vertical", SHORT),
    "single_mass_zero_gravity": Case("single_mass_zero_gravity", SHORT),
    "AC and IEPE": Case(
        "nulls",
        (
            "acquire.settle=20 cycles",
            "acquire.record=4 cycles",
            "repeats=2",
            "acquire.coupling={force: IEPE, acceleration: AC}",
            "acquire.effects=[linearity, resonance, flicker]",
        ),
        NULL,
    ),
    "ideal instruments": Case(
        "nulls",
        (*SHORT, "acquire.analyzer=ideal", "acquire.sensors={force: ideal, acceleration: ideal}"),
        NULL,
    ),
    "light box, coupled": Case(
        TEXT.format(scene=LIGHT, vary=BEDS, repeats=1, settle=4),
        ("drive.mode=shaker",),
        seeds=100,
    ),
    "hysteresis": Case(
        "hysteresis", (*SHORT, "repeats=2"), ("drive.acceleration=[1, 3]",), seeds=100
    ),
    "gauge": Case(
        "gauge",
        (*SHORT, "repeats=2", "drive.acceleration=2"),
        ("scene.bed=[empty, locked]",),
        seeds=100,
    ),
    "stepped_sine": Case(
        "stepped_sine",
        SHORT,
        ("scene.bed=[empty, locked]", "drive.frequency=[5, 10, 20]"),
        seeds=100,
    ),
    "sweep": Case(
        "sweep",
        ("acquire.settle=4 cycles", "acquire.record=20 cycles"),
        ("scene.bed=[empty, locked]",),
        seeds=40,
    ),
}
"""Healthy rigs. The shipped protocols have records of 4 cycles after 4: their instruments,
fillings, levels and noise are drawn as ever, and a session takes a sixth of the time. `four fills`
is as long as it is shipped."""


def session_of(plan: Plan, seed: int) -> tuple[MemoryRecord, dict[str, Any]]:
    record = plan.session(seed)
    return record, read_session(record).document()


def allowed(count: int, chance: float = 0.025) -> int:
    """The number of failures that a true fraction FAILING exceeds with less than
    this chance.
    """
    return int(stats.binom.ppf(1 - chance, count, FAILING))


def failures(plan: Plan, count: int, first: int = 1) -> tuple[int, Counter[str]]:
    """Sessions that fail, of the given seeds, and the checks that they fail."""
    failed, checks = 0, Counter[str]()
    for seed in range(first, first + count):
        _, report = session_of(plan, seed)
        failed += report["verdict"] == "fails"
        checks.update(sentence[:60] for sentence in report["failures"])
    return failed, checks


def test_so_many_may_fail() -> None:
    assert (allowed(400), allowed(100), allowed(40)) == (29, 10, 5)


def test_a_healthy_light_box_passes() -> None:
    failed, checks = failures(HEALTHY["light box, once"].plan(), 40)
    assert failed <= allowed(40, 1e-3), checks


def test_a_healthy_open_loop_passes() -> None:
    """At 2 Hz the losses exceed the empty box's inertia by half, and the motion has 12 % of
    harmonics: a quadratic loss then looks like 1.6 % of mass. Before that was in U, 16 of 40
    sessions failed."""
    failed, checks = failures(HEALTHY["sweep"].plan(), 12)
    assert failed <= allowed(12, 1e-2), checks


def test_a_healthy_rig_passes_wherever_its_instruments_are() -> None:
    """Through the stinger the locked bed reads 94 kg for 50 kg, and five times the loss, at 50 Hz.
    Brought to the box the mass holds within U, and W_exp agrees with a ledger that has the
    stinger's loss; its angle decides nothing. 4 standard deviations (2 U) for twelve numbers."""
    head = Case(
        "gauge",
        (*SHORT, "repeats=2", "drive.acceleration=2"),
        ("scene.bed=[empty, locked]", "drive.frequency=[50]"),
    )
    _, report = session_of(head.plan(), 1)
    assert report["verdict"] == "passes"
    assert all(abs(row["E_n_truth"]) < 2 for row in report["conditions"])
    masses = [row for row in report["references"] if row["reference"] == "rigid mass"]
    assert len(masses) == 6
    assert all(abs(row["value"] - row["expected"]) < 2 * row["U"] for row in masses)
    assert max(row["M_eff"] for row in report["conditions"]) > 80
    assert ["stinger" in row["why"] for row in report["nulls"]] == [False, False, True]


@pytest.mark.slow
@pytest.mark.parametrize("name", HEALTHY)
def test_healthy_rigs_pass(name: str) -> None:
    """At most 29 of 400: exceeded by a true fraction of 5 % with a probability of 2 %."""
    case = HEALTHY[name]
    failed, checks = failures(case.plan(), case.seeds)
    assert failed <= allowed(case.seeds), checks


def late(
    seconds: Callable[[MemoryRecord], float],
) -> Callable[[MemoryRecord, ChannelInfo], ChannelInfo]:
    """The acceleration lags by so much more than is believed."""
    return lambda record, channel: replace(channel, skew=channel.skew + seconds(record))


def a_sample(record: MemoryRecord) -> float:
    return 1 / record.runs[0].rate


def an_angle(radians: float) -> Callable[[MemoryRecord], float]:
    return lambda record: (
        radians / (2 * math.pi * next(iter(record.conditions.values()))["frequency"])
    )


FAULTS: dict[str, Callable[[MemoryRecord, ChannelInfo], ChannelInfo]] = {
    "skew of a sample": late(a_sample),
    "skew of a sample, the other way": late(lambda record: -a_sample(record)),
    "a pole left out": lambda _, channel: replace(channel, time_constant=None),
    "a sign swapped": lambda _, channel: replace(channel, sensitivity=-channel.sensitivity),
    "5 mrad": late(an_angle(5e-3)),
    "5 mrad, the other way": late(an_angle(-5e-3)),
}
"""What the analysis believes of the accelerometer's channel, instead of what is so."""
FAULTY = {
    "light box": HEALTHY["light box"],
    "light box, once": HEALTHY["light box, once"],
    "fill_rate": Case("fill_rate", SHORT, ("scene.grains.fill=[0, 0.3, 0.85, 1]",)),
    "nulls": Case("nulls", SHORT, ("scene.bed=[empty, locked]",)),
}


def misbelieved(record: MemoryRecord, fault: str, truth: bool = True) -> dict[str, Any]:
    """The report of a record by an analysis that believes something else of its instruments; truth:
    with the rig's own ledger beside it."""
    wrong = copy(record)
    channel = record.channels["acceleration"]
    wrong.channels = {**record.channels, "acceleration": FAULTS[fault](record, channel)}
    if not truth:
        wrong.truth, wrong.synthetic = None, False
    return read_session(wrong).document()


def power(
    plan: Plan, count: int, faults: list[str], first: int = 1, alone: bool = False
) -> Counter[str]:
    """The sessions in which each fault is found; alone: by nulls, references and
    signs, without ledger.
    """
    found = Counter[str]()
    for seed in range(first, first + count):
        record = plan.session(seed)
        for fault in faults:
            found[fault] += misbelieved(record, fault)["verdict"] == "fails"
            if alone:
                found[f"{fault}, no ledger"] += (
                    misbelieved(record, fault, truth=False)["verdict"] == "fails"
                )
    return found


def test_faults_are_found() -> None:
    """Fewer than 5 of 6 at a power of 95 % with a chance of 3 %; these six are of the 200 of the
    slow test.
    """
    found = power(FAULTY["light box, once"].plan(), 6, list(FAULTS))
    assert {fault: count for fault, count in found.items() if count < 5} == {}


@pytest.mark.slow
@pytest.mark.parametrize("name", FAULTY)
def test_faults_are_found_in_95_of_100_sessions(name: str) -> None:
    found = power(FAULTY[name].plan(), 200, list(FAULTS))
    assert {fault: count for fault, count in found.items() if count < FOUND * 200} == {}


ERRORS = ("{skew: 1}", "{pole: 0.5}")  # 12.6 and 5 mrad at 20 Hz


def found(error: str, count: int) -> int:
    """Sessions that fail, of `count` with a deliberate error in the record itself."""
    case = made(ROWS, BEDS, settle=10)
    return failures(Case(case.protocol + f"deliberate_error: {error}\n").plan(), count)[0]


@pytest.mark.parametrize("error", ERRORS)
def test_a_deliberate_error_is_found(error: str) -> None:
    assert found(error, 4) == 4


@pytest.mark.slow
@pytest.mark.parametrize("error", ERRORS)
def test_a_deliberate_error_is_found_in_95_of_100_sessions(error: str) -> None:
    assert found(error, 100) >= 95


def main(count: int, names: list[str]) -> None:
    for name in names or HEALTHY:
        if name in HEALTHY:
            case = HEALTHY[name]
            failed, checks = failures(case.plan(), min(count, case.seeds))
            print(f"{name}: {failed} of {min(count, case.seeds)} fail {dict(checks)}", flush=True)
    for name in names or FAULTY:
        if name in FAULTY:
            many = min(count, 200)
            for fault, times in power(FAULTY[name].plan(), many, list(FAULTS), alone=True).items():
                print(f"{name}, {fault}: found in {times} of {many}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2:])
