"""How often claims are judged wrongly on whole sessions: instruments, fillings, levels and noise
drawn anew, read from their codes, each claim at the edge where it is only just false. `python
tests/road/test_claims_sessions.py 500` prints the shares."""

import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from memory_session import OUTSIDE_THE_INSTRUMENTS, MemoryRecord, Plan
from scipy import stats

from analysis import read_session, run_energy
from analysis.results.run import RunEnergy
from analysis.session.ledger_columns import DISSIPATED
from rig.campaign.claim_cases import cases
from rig.protocol.grid import conditions
from rig.protocol.load import load_protocol

TEXT = """\
schema: rig/protocol/1
name: claims
scene: {{grains: {{material: stainless, diameter: 8 mm, fill: 85 %}}, layers: {{rows: {rows}}}}}
drive: {{acceleration: 4 m/s^2}}
acquire: {{settle: 4 cycles, record: 4 cycles}}
vary: {{{vary}}}
repeats: 4
expect:
"""


Limits = Sequence[Sequence[float]]
"""Of each claim of a case, empty: those in the claim."""


@dataclass(frozen=True)
class Case:
    """Sessions of one plan and the claims about them. edge: limits that make the claims only just
    false, of all sessions; they take the place of those in the claim."""

    vary: str
    claims: tuple[str, ...]
    edge: Callable[[Sequence["Read"]], Limits]
    rows: int = 2


@dataclass(frozen=True)
class Read:
    """A session without its codes, the energies of its runs, and true W (J) by condition, mean over
    the refills.
    """

    record: MemoryRecord
    energies: Mapping[str, RunEnergy]
    true: np.ndarray


def exponent(found: Sequence[Read]) -> Limits:
    """How far the slope of ln W over ln a is off 2, of all refills."""
    W = np.log([s.true for s in found]).mean(axis=0)
    a = np.log([condition["acceleration_set"] for condition in found[0].record.conditions.values()])
    return [[abs(float(np.polyfit(a, W, 1)[0]) - 2)]]


def share(found: Sequence[Read]) -> Limits:
    """W of the first condition over that of the second."""
    low, full = np.mean([s.true for s in found], axis=0)
    return [[float(low / full)]]


def offset(found: Sequence[Read]) -> Limits:
    """From W over W_T at the levels reached, less 1 (refills and the box's losses), to far away,
    and the other way.
    """
    ratios = []
    for session in found:
        rows = read_session(session.record, session.energies).document()["conditions"]
        W_T = np.array([row["W_T"] for row in rows])
        apart = [sum(row["offset_terms"][name] for name in OUTSIDE_THE_INSTRUMENTS) for row in rows]
        ratios.append(float(W_T @ apart / W_T.sum()))
    edge = float(np.mean(ratios))
    return [[edge, 10.0], [-0.9, edge]]


WALL = "scene.cavity.wall"
CASES = {
    # A thicker wall adds mass and nothing else: three values whose W is the same, with three
    # reactive forces.
    "alike": Case(
        f"{WALL}: [4 mm, 5 mm, 6 mm]",
        (
            f"optimum: {WALL}, value: 5 mm",
            f"optimum: {WALL}, value: [4 mm, 5 mm]",
            f"order: {WALL}, values: [4 mm, 5 mm, 6 mm]",
            f"rise: {WALL}, from: 4 mm, to: 6 mm",
            f"fall: {WALL}, from: 4 mm, to: 6 mm",
            f"rise: {WALL}, from: 4 mm, to: 6 mm, imposed: put in",
        ),
        lambda _: [],
    ),
    # The first step is clear, the second flat: where a false order or a false best is most likely.
    "one step flat": Case(
        f"zip.ends: {{{WALL}: [4 mm, 5 mm, 6 mm], scene.grains.fill: [60 %, 85 %, 85 %]}}",
        (
            f"rise: {WALL}, from: 4 mm, to: 6 mm",
            f"order: {WALL}, values: [4 mm, 6 mm, 5 mm]",
            f"optimum: {WALL}, value: 6 mm",
        ),
        lambda _: [],
    ),
    "power law": Case(
        "drive.acceleration: [3 m/s^2, 4 m/s^2, 5 m/s^2]",
        ("nonlinear: drive.acceleration",),
        exponent,
    ),
    "nearly zero": Case(
        "scene.grains.fill: [20 %, 85 %]",
        ("nearly_zero: scene.grains.fill, value: 20 %, full: 85 %",),
        share,
    ),
    "offset": Case(
        "drive.acceleration: [3 m/s^2, 4 m/s^2]",
        ("offset_within: [0, 1]", "offset_within: [-1, 0]"),
        offset,
        rows=4,
    ),
}


def sessions(case: Case, count: int) -> list[Read]:
    plan, found = Plan.of(TEXT.format(vary=case.vary, rows=case.rows) + "  []\n"), []
    for seed in range(1, count + 1):
        record = plan.session(seed)
        energies = {run.name: run_energy(record, run) for run in record.runs}
        record.forget()
        true = [
            np.mean([lost(e) for e in energies.values() if e.condition == name])
            for name in record.conditions
        ]
        found.append(Read(record, energies, np.array(true)))
    return found


def lost(run: RunEnergy) -> float:
    """What a run dissipated, from its ledger, J per cycle."""
    return sum((run.ledger or {}).get(name, 0.0) for name in DISSIPATED)


def verdicts(case: Case, count: int) -> dict[str, Counter[str]]:
    """Claim -> how often each verdict."""
    found = sessions(case, count)
    text = TEXT.format(vary=case.vary, rows=case.rows)
    protocol = load_protocol(
        text + "".join(f"  - {{claim: it is so, {claim}}}\n" for claim in case.claims)
    )
    entries: list[dict[str, Any]] = cases(protocol, conditions(protocol))
    for entry, limits in zip(entries, case.edge(found), strict=False):
        entry["limits"] = list(limits)
    counts: dict[str, Counter[str]] = {claim: Counter() for claim in case.claims}
    for session in found:
        session.record.documents["protocol"] = {"expect": entries}
        judged = read_session(session.record, session.energies).document()["claims"]
        for claim, entry in zip(case.claims, judged, strict=True):
            counts[claim][entry["verdict"]] += 1
    return counts


def check(name: str, count: int) -> None:
    """No claim may hold in more than 5 % of the sessions, nor be denied where its edge makes it
    just true as well.
    """
    most = int(stats.binom.ppf(0.999, count, 0.05))
    for claim, counts in verdicts(CASES[name], count).items():
        print(f"{count} sessions, {claim}: {dict(counts)}")
        assert sum(counts.values()) == count
        assert counts["holds"] <= most, claim
        assert counts["does not hold"] <= most, claim
        assert not (counts["holds"] and "imposed" in claim)


@pytest.mark.parametrize("name", CASES)
def test_claims_are_rarely_judged_wrongly(name: str) -> None:
    """5 % within the 99.9 % binomial band of 40 sessions. Its slow twin has 500; over 3000 sessions
    a flat step was told to rise or fall in 5.1 +- 0.3 %."""
    check(name, 40)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_claims_are_rarely_judged_wrongly_in_500_sessions(name: str) -> None:
    check(name, 500)


if __name__ == "__main__":
    for each in CASES:
        check(each, int(sys.argv[1]))
