"""Which claims of a protocol its repeats can decide: the report's own tests, on the session that is
to be expected.

Every condition has the energies that were looked at, its refills lie evenly over their distribution,
and instruments are as good as their certificates: what the tests then say of a claim is what most
sessions of that many repeats will say.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from analysis.claims import judge
from analysis.conditions import Result, evaluate
from analysis.energy import Energy
from analysis.runs import RunEnergy, Setting
from analysis.uncertainty import noise_of
from daq.channel import ChannelInfo

__all__ = ["MOST", "Decision", "Expected", "decisions"]

UNDECIDED = "undecided"
MOST = 100
TRIED = (2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64, MOST)
"""Numbers of repeats."""


@dataclass(frozen=True)
class Expected:
    """A condition as it will be measured: facts of the session, energy W that is expected (J per
    cycle), apparent mass (kg), level (m/s^2), its entry in the prediction document, the samples that
    count, energies of poured beds over W_T."""

    facts: Mapping[str, Any]
    W: float
    mass: float
    level: float
    entry: Mapping[str, Any] | None
    samples: int
    refills: Sequence[float]


@dataclass(frozen=True)
class Decision:
    """A claim before it is measured. verdict: expected with the protocol's repeats; repeats: fewest
    of TRIED from which on it is decided, None where MOST are not enough; found: what is expected then;
    why: in the report's words."""

    claim: str
    verdict: str
    repeats: int | None
    found: str
    why: str


def decisions(
    claims: Sequence[Mapping[str, Any]], expected: Sequence[Expected], channels: Sequence[ChannelInfo], repeats: int
) -> list[Decision]:
    """Return what can be decided of each claim (entries of `rig.cases.cases`)."""
    if not claims:
        return []
    by_name = {channel.name: channel for channel in channels}
    tried = {n: judge(claims, _results(expected, by_name, n)) for n in sorted({repeats, *TRIED})}
    found = []
    for place, claim in enumerate(claims):
        verdicts = {n: rows[place] for n, rows in tried.items()}
        needed: int | None = None
        for n in sorted(TRIED, reverse=True):
            if verdicts[n]["verdict"] == UNDECIDED:
                break
            needed = n
        row = verdicts[repeats if needed is not None and needed <= repeats else needed or MOST]
        found.append(Decision(claim["claim"], verdicts[repeats]["verdict"], needed, row["found"], row["why"]))
    return found


def _results(expected: Sequence[Expected], channels: Mapping[str, ChannelInfo], n: int) -> dict[str, Result]:
    found = {}
    for one in expected:
        setting = Setting.of(one.facts)
        W = _energies(one, n)
        phasor = np.array([one.level + 0j])
        runs = []
        for place, w in enumerate(W, 1):
            turned = np.asarray(
                one.mass * phasor + 1j * w * (2.0 * np.pi * setting.frequency) ** 2 / (np.pi * one.level), complex
            )
            cycles = max(int(setting.record_cycles), 1)
            energy = Energy(setting.frequency, cycles, w, np.full(cycles, w), w, 0.0, w, turned, phasor)
            noise = noise_of(energy, channels["force"], channels["acceleration"], one.samples)
            runs.append(RunEnergy(f"{setting.id}_{place}", setting.id, place, place, energy, u_noise=noise))
        found[setting.id] = evaluate(setting, runs, one.entry, channels)
    return found


def _energies(one: Expected, n: int) -> list[float]:
    """W of n repeats, evenly over the distribution of the refills, with its mean and variance."""
    if n == 1 or not one.refills or one.entry is None:
        return [one.W] * n
    poured = np.array(one.refills) * float(np.median(one.entry["W_T"]))
    drawn = np.quantile(poured, (np.arange(n) + 0.5) / n)
    drawn = (drawn - drawn.mean()) * (poured.std(ddof=1) / drawn.std(ddof=1) if drawn.std() else 1.0)
    return [float(w) for w in one.W + poured.mean() - float(np.median(one.entry["W_T"])) + drawn]
