"""How often the true best fill is excluded, and how often it is found, with refills of the bed itself: sd of ln W from
.01 to .16, skewed. `PYTHONPATH=. python tests/physics/test_claims_scatter.py 1500` prints both beside the test that pools
one scatter (Dunnett's, as it was before), at 4 and 8 refills.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from analysis.claim_tests import LEVEL, Level, Scatter, logs
from analysis.conditions import Result, evaluate
from analysis.energy import Energy
from analysis.multiple import beaten
from analysis.runs import RunEnergy, Setting
from daq.channel import AnalyzerSpec, Channel, channel_info, ideal_transducer
from rig.beds.stack import refill
from rig.catalog import load_rig
from rig.model import predict, total_of
from rig.plan import condition_facts
from rig.protocol import load_protocol
from rig.refills import refill_ratios

PROTOCOL = Path("protocols/fill_rate.yaml")
LEVEL_ERROR, EXPONENT = 0.003, 3.0  # of the drive, relative; of W over the level
CLEAR = {4: 0.15, 8: 0.10}  # refills -> ln of how far the best is above all others, where the power is asked


@dataclass(frozen=True)
class Bank:
    """Conditions [level][fill] with the refills that the session would state, and W over its mean of beds poured apart
    from them, shape (levels, fills, pourings)."""

    settings: list[list[Setting]]
    refills: list[list[tuple[float, ...]]]
    channels: dict
    W: np.ndarray


def bank(fills: list[str], levels: list[int], count: int) -> Bank:
    protocol = load_protocol(
        PROTOCOL.read_text(encoding="utf-8"),
        sets=[],
        varies=[
            f"scene.grains.fill=[{', '.join(fills)}]",
            f"drive.acceleration=[{', '.join(f'{a} m/s^2' for a in levels)}]",
        ],
    )
    rig, rng = load_rig(protocol.rig), np.random.default_rng(8)
    settings, refills, W = [], [], []
    for condition in protocol.conditions():
        scene, drive, point = condition.scene, condition.drive, predict(condition, rig)
        settings.append(Setting.of(condition_facts(condition, rig, point, 10240.0)))
        refills.append(refill_ratios(condition, rig, point.W_T))
        beds = (refill(scene, rig, rng) for _ in range(count))
        W.append([total_of(scene, rig, bed, drive.acceleration, drive.frequency).total for bed in beds])
    spec = AnalyzerSpec("test", (10240.0,))
    channels = {
        name: channel_info(Channel(name, ideal_transducer(name), 10.0, "", ""), spec, 10240.0, 39.0)
        for name in ("force", "acceleration")
    }
    by_level = [list(range(a, len(settings), len(levels))) for a in range(len(levels))]
    drawn = np.array(W)
    ln = np.log(drawn) - np.log(drawn).mean(axis=1, keepdims=True)
    return Bank(
        [[settings[i] for i in row] for row in by_level],
        [[refills[i] for i in row] for row in by_level],
        channels,
        np.exp(np.array([ln[row] for row in by_level])),
    )


def measured(found: Bank, rng: np.random.Generator, n: int, is_told: bool) -> list[list[Result]]:
    """A session in which all fills are alike in the mean of ln W. is_told: it states the prediction's refills."""

    def one(a: int, f: int) -> Result:
        setting = found.settings[a][f]
        off = np.exp(LEVEL_ERROR * rng.standard_normal(n))
        W = rng.choice(found.W[a, f], n, replace=False) * off**EXPONENT
        mass, runs = setting.box_mass + setting.bed_mass, []
        for place, (w, level) in enumerate(zip(W, setting.acceleration_set * off, strict=True)):
            phasor = np.array([level + 0j])
            energy = Energy(20.0, 40, float(w), np.full(40, w), float(w), 0.0, float(w), mass * phasor, phasor)
            runs.append(RunEnergy(f"{setting.id}{place}", setting.id, place, place, energy))
        levels = [setting.acceleration_set * k for k in (0.97, 1.0, 1.03)]
        entry = {"acceleration": levels, "W_T": [(x / setting.acceleration_set) ** EXPONENT for x in levels]}
        refills = {"refills": list(found.refills[a][f])} if is_told else {}
        return evaluate(setting, runs, {**entry, **refills}, found.channels)

    return [[one(a, f) for f in range(len(row))] for a, row in enumerate(found.settings)]


def pooled(means: np.ndarray, s: float, critical: float, n: int) -> np.ndarray:
    """The fills that the pooled scatter excludes."""
    others = np.array([np.delete(means, f).max() for f in range(len(means))])
    return (others - means) / (s * np.sqrt(2 / n)) > critical


def dunnett(k: int, nu: float) -> float:
    """One-sided critical value against k others at 5 %, from its definition."""
    rng = np.random.default_rng(0)
    z, own = rng.standard_normal((k, 200_000)), rng.standard_normal(200_000)
    s = np.sqrt(rng.chisquare(nu, 200_000) / nu)
    return float(np.quantile((z.max(axis=0) - own) / np.sqrt(2) / s, 0.95))


@dataclass
class Shares:
    """Of the sessions, shape (levels, fills): in which a fill is excluded though none is better, and in which it is told
    to be the only best where it is better than all others by CLEAR; by the claims' test and with one pooled scatter."""

    excluded: np.ndarray
    found: np.ndarray
    excluded_pooled: np.ndarray
    found_pooled: np.ndarray


def shares(source: Bank, n: int, sessions: int, is_told: bool = True) -> Shares:
    levels, fills = source.W.shape[:2]
    count, rng = np.zeros((4, levels, fills)), np.random.default_rng(9)
    critical = dunnett(fills - 1, fills * (n - 1))
    for _ in range(sessions):
        session = measured(source, rng, n, is_told)
        scatter = Scatter.of(result for row in session for result in row)
        for a, row in enumerate(session):
            told = logs([Level(str(f), (result,)) for f, result in enumerate(row)], scatter)
            assert told is not None
            ln = np.array([[np.log(run.energy.W) for run in result.runs] for result in row])
            mean, s = ln.mean(axis=1), float(np.sqrt(ln.var(axis=1, ddof=1).mean()))
            count[0, a] += beaten(told.means, LEVEL, told.most)
            count[2, a] += pooled(mean, s, critical, n)
            for f in range(fills):
                raised = [(m + CLEAR[n] * (f == j), v, nu) for j, (m, v, nu) in enumerate(told.means)]
                out = beaten(raised, LEVEL, told.most)
                count[1, a, f] += not out[f] and sum(out) == fills - 1
                out = pooled(mean + CLEAR[n] * (np.arange(fills) == f), s, critical, n)
                count[3, a, f] += not out[f] and out.sum() == fills - 1
    return Shares(*count / sessions)


FILLS, LEVELS = ["10 %", "30 %", "50 %", "70 %", "80 %", "85 %", "90 %", "95 %"], [2, 3, 4, 5]


def test_the_true_best_is_rarely_excluded():
    """5 % of 200 sessions, within the 99.9 % band of each of 8 (0.1 % in eight: 99.99 %); at 90 % fill and 5 m/s^2,
    where refills are most skewed, beside the pooled scatter, which excludes more often than that (at 4 refills)."""
    source = bank(["10 %", "50 %", "90 %", "95 %"], [2, 5], 150)
    for n in CLEAR:
        found = shares(source, n, 200)
        assert found.excluded.max() * 200 <= stats.binom.ppf(0.9999, 200, 0.05)
    assert found.excluded.max() < found.excluded_pooled.max()


@pytest.mark.slow
@pytest.mark.parametrize("n", CLEAR)
def test_the_true_best_is_rarely_excluded_in_1500_sessions(n):
    """Each of the 32 conditions within the band of 0.1 % in 32."""
    found = shares(bank(FILLS, LEVELS, 600), n, 1500)
    assert found.excluded.max() * 1500 <= stats.binom.ppf(1 - 0.001 / 32, 1500, 0.05)


def main(sessions: int) -> None:
    source = bank(FILLS, LEVELS, 1000)
    for n, clear in CLEAR.items():
        for is_told in (True, False):
            found = shares(source, n, sessions, is_told)
            print(
                f"{n} refills, {'refills stated' if is_told else 'no refills stated'}, %: this test / one pooled scatter"
            )
            for name, ours, theirs in (
                ("excluded, none better", found.excluded, found.excluded_pooled),
                (f"only best, better by {clear}", found.found, found.found_pooled),
            ):
                print(f"  {name}: mean {100 * ours.mean():.1f} / {100 * theirs.mean():.1f}, "
                      f"largest {100 * ours.max():.1f} / {100 * theirs.max():.1f}")  # fmt: skip
                for a, row in zip(LEVELS, zip(ours, theirs, strict=True), strict=True):
                    pairs = (f"{100 * x:.0f}/{100 * y:.0f}" for x, y in zip(*row, strict=True))
                    print(f"    {a} m/s^2: {', '.join(pairs)}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]))
