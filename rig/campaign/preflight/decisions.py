"""Claims of a protocol that its repeats can decide: the report's own tests on simulated sessions.

Every condition has the energy of its dry run, refills are drawn from the predicted ones, and
instruments agree with their certificates. The result of four in five such sessions is expected of
the real one.
"""

from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from analysis.comparison.claims import judge
from analysis.energy.energy_and_phasors import Energy
from analysis.results.condition import Result, evaluate
from analysis.results.judged_rows import ClaimRow
from analysis.results.run import RunEnergy
from analysis.session.prediction_entry import PredictionEntry
from analysis.session.protocol import ExpectedClaim
from analysis.session.setting import Setting
from analysis.uncertainty.budget import noise_of
from daq.chain.channel import ChannelInfo

__all__ = ["MOST", "Decision", "Expected", "decisions"]

UNDECIDED = "undecided"
MOST = 100
TRIED = (2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64, MOST)
"""Trial numbers of repeats."""
SHARE = 0.8
"""Fraction of the simulated sessions in which a claim must be decided."""
DRAWN, FEWEST, SEED = 40, 3, 1
"""Total repeats drawn over all sessions with one number of repeats, least number of sessions, and
the seed.
"""


@dataclass(frozen=True)
class Expected:
    """A condition as it is expected to be measured.

    facts : of the session
    W : expected energy, J per cycle
    mass : apparent mass, kg
    level : m/s^2
    entry : its entry in the prediction document
    samples : number of analysed samples
    refills : energies of refilled beds divided by `W_own`, the bed's own prediction, J per cycle
    """

    facts: Mapping[str, Any]
    W: float
    mass: float
    level: float
    entry: PredictionEntry | None
    samples: int
    refills: Sequence[float]
    W_own: float


@dataclass(frozen=True)
class Decision:
    """Forecast of a claim before it is measured.

    verdict : expected with the protocol's repeats
    repeats : smallest of TRIED with which it is decided in the fraction `SHARE` of the sessions,
        None if MOST are not enough
    found, why : of such a session, in the report's words
    """

    claim: str
    verdict: str
    repeats: int | None
    found: str
    why: str


def decisions(
    claims: Sequence[ExpectedClaim],
    expected: Sequence[Expected],
    channels: Sequence[ChannelInfo],
    repeats: int,
) -> list[Decision]:
    """Return the forecast of each claim (entries of `rig.campaign.claim_cases.cases`)."""
    if not claims:
        return []
    by_name = {channel.name: channel for channel in channels}

    @cache
    def entries_of(n: int) -> list[tuple[ClaimRow, ...]]:
        """Return the report's entries of all claims, for each simulated session of n repeats."""
        streams = (
            np.random.default_rng([SEED, n, place]) for place in range(max(FEWEST, DRAWN // n))
        )
        return [judge(claims, _results(expected, by_name, n, rng)) for rng in streams]

    return [
        _decision(place, claim.claim, entries_of, repeats) for place, claim in enumerate(claims)
    ]


def _decision(
    place: int, claim: str, entries_of: Callable[[int], list[tuple[ClaimRow, ...]]], repeats: int
) -> Decision:
    """Return the forecast of the claim at a place; `entries_of` returns the entries of all claims
    by session.
    """

    def leading(n: int) -> tuple[str, float, float]:
        """Return the most frequent verdict, its fraction of the sessions, and the decided fraction."""
        found = [session[place].verdict for session in entries_of(n)]
        verdict, count = Counter(found).most_common(1)[0]
        return verdict, count / len(found), sum(one != UNDECIDED for one in found) / len(found)

    needed: int | None = None
    if leading(MOST)[2] >= SHARE:
        # Bisection: more repeats decide more, and each trial costs full sessions.
        needed = TRIED[bisect_left(TRIED, True, key=lambda n: leading(n)[2] >= SHARE)]
    verdict, share, _ = leading(repeats)
    shown = repeats if needed is not None and needed <= repeats else needed or MOST
    row = next(
        session[place]
        for session in entries_of(shown)
        if session[place].verdict == leading(shown)[0]
    )
    return Decision(claim, verdict if share >= SHARE else UNDECIDED, needed, row.found, row.why)


def _results(
    expected: Sequence[Expected],
    channels: Mapping[str, ChannelInfo],
    n: int,
    rng: np.random.Generator,
) -> dict[str, Result]:
    """Return the results of one simulated session of n repeats, by condition."""
    found = {}
    for one in expected:
        setting = Setting.of(one.facts)
        W = _energies(one, n, rng)
        phasor = np.array([one.level + 0j])
        runs = []
        for place, w in enumerate(W, 1):
            turned = np.asarray(
                one.mass * phasor
                + 1j * w * (2.0 * np.pi * setting.frequency) ** 2 / (np.pi * one.level),
                complex,
            )
            cycles = max(int(setting.record_cycles), 1)
            energy = Energy(
                setting.frequency, cycles, w, np.full(cycles, w), w, 0.0, w, turned, phasor
            )
            noise = noise_of(energy, channels["force"], channels["acceleration"], one.samples)
            runs.append(
                RunEnergy(f"{setting.id}_{place}", setting.id, place, place, energy, u_noise=noise)
            )
        found[setting.id] = evaluate(setting, runs, one.entry, channels)
    return found


def _energies(one: Expected, n: int, rng: np.random.Generator) -> list[float]:
    """Return W of n repeats, J per cycle: refills drawn from the predicted ones."""
    if n == 1 or not one.refills or one.entry is None:
        return [one.W] * n
    return [float(one.W + one.W_own * (ratio - 1.0)) for ratio in rng.choice(one.refills, n)]
