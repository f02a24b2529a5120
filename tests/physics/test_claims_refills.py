"""Claims about beds that are the same: W of poured beds, which no normal distribution is, through
the claims' tests.
"""

import numpy as np
import pytest
from scipy import stats

from analysis.comparison.claim_tests import TESTS, Level, Question
from analysis.energy.energy_and_phasors import Energy
from analysis.results.condition import evaluate
from analysis.results.run import RunEnergy
from analysis.session.setting import Setting
from daq.chain.channel import AnalyzerSpec, Channel, channel_info, ideal_transducer
from rig.beds.janssen_stack import refill
from rig.catalog.rig_file import load_rig
from rig.prediction.document import condition_facts
from rig.prediction.own import total_of
from rig.protocol.grid import conditions
from rig.protocol.load import load_protocol

TEXT = """\
schema: rig/protocol/1
name: refills
scene: {grains: {material: stainless, diameter: 8 mm, fill: 85 %}, layers: {rows: 2}}
drive: {acceleration: 4 m/s^2}
"""
N = 4


@pytest.fixture(scope="module")
def poured():
    """Condition, channels and W (J) of 150 pourings."""
    from rig.prediction.model import predict

    protocol = load_protocol(TEXT)
    condition, rig, rng = conditions(protocol)[0], load_rig(protocol.rig), np.random.default_rng(8)
    drive, scene = condition.drive, condition.scene
    W = [
        total_of(scene, rig, refill(scene, rig, rng), drive.acceleration, drive.frequency).total
        for _ in range(150)
    ]
    spec = AnalyzerSpec("test", (10240.0,))
    channels = {
        name: channel_info(Channel(name, ideal_transducer(name), 10.0, "", ""), spec, 10240.0, 39.0)
        for name in ("force", "acceleration")
    }
    setting = Setting.of(condition_facts(condition, rig, predict(condition, rig), 10240.0))
    return setting, channels, np.array(W)


def level(rng, poured, label):
    setting, channels, pool = poured
    phasor = np.array([setting.acceleration_set + 0j])
    mass = setting.box_mass + setting.bed_mass
    runs = [
        RunEnergy(
            f"{label}{i}",
            label,
            i,
            i,
            Energy(20.0, 40, W, np.full(40, W), W, 0.0, W, mass * phasor, phasor),
        )
        for i, W in enumerate(rng.choice(pool, N))
    ]
    return Level(label, (evaluate(setting, runs, None, channels),))


@pytest.mark.parametrize("trials", [400, pytest.param(2000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("kind", ["optimum", "order", "rise", "fall"])
@pytest.mark.parametrize("count", [2, 4])
def test_equal_beds_are_rarely_distinguished(poured, kind, count, trials):
    """The same fill under several names: every "holds" is false, and is found in at most 5 %
    (more often in 0.1 % of all seeds)."""
    rng = np.random.default_rng(9)
    labels = [str(i) for i in range(count)]
    question = Question(("0",) if kind == "optimum" else (labels[0], labels[-1]), (), 1)
    found = [
        TESTS[kind]([level(rng, poured, name) for name in labels], question).verdict
        for _ in range(trials)
    ]
    assert found.count("holds") <= stats.binom.ppf(0.999, trials, 0.05)
