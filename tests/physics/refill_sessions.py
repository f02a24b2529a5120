"""Sessions whose refills are those of the bed itself: sd of ln W from .01 to .16, skewed."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis.energy.energy_and_phasors import Energy
from analysis.results.condition import Result, evaluate
from analysis.results.run import RunEnergy
from analysis.session.prediction_entry import PredictionEntry
from analysis.session.setting import Setting
from daq.chain.channel import AnalyzerSpec, Channel, ChannelInfo, channel_info, ideal_transducer
from daq.documents.classes import built
from rig.beds.janssen_stack import refill
from rig.catalog.rig_file import load_rig
from rig.prediction.document import condition_facts
from rig.prediction.model import predict
from rig.prediction.own import total_of
from rig.prediction.refills import refill_ratios
from rig.protocol.grid import conditions
from rig.protocol.load import load_protocol

PROTOCOL = Path(__file__).parents[2] / "protocols" / "fill_rate.yaml"
FILLS, LEVELS = ("10 %", "30 %", "50 %", "70 %", "80 %", "85 %", "90 %", "95 %"), (2, 3, 4, 5)
LEVEL_ERROR, EXPONENT = 0.003, 3.0  # of the drive, relative; of W over the level


@dataclass(frozen=True)
class Bank:
    """Conditions [level][fill] with the refills that the session would state, and W over its
    geometric mean of beds poured apart from them, shape (levels, fills, pourings)."""

    settings: list[list[Setting]]
    refills: list[list[tuple[float, ...]]]
    channels: dict[str, ChannelInfo]
    W: np.ndarray

    @classmethod
    def of(cls, fills: Sequence[str], levels: Sequence[int], count: int) -> "Bank":
        varies = [
            f"scene.grains.fill=[{', '.join(fills)}]",
            f"drive.acceleration=[{', '.join(f'{a} m/s^2' for a in levels)}]",
        ]
        protocol = load_protocol(PROTOCOL, [], varies)
        rig, rng = load_rig(protocol.rig), np.random.default_rng(8)
        settings, refills, W = [], [], []
        for condition in conditions(protocol):
            scene, drive, point = condition.scene, condition.drive, predict(condition, rig)
            settings.append(Setting.of(condition_facts(condition, rig, point, 10240.0)))
            refills.append(refill_ratios(condition, rig, point.W_T))
            beds = (refill(scene, rig, rng) for _ in range(count))
            W.append(
                [
                    total_of(scene, rig, bed, drive.acceleration, drive.frequency).total
                    for bed in beds
                ]
            )
        spec = AnalyzerSpec("test", (10240.0,))
        channels = {
            name: channel_info(
                Channel(name, ideal_transducer(name), 10.0, "", ""), spec, 10240.0, 39.0
            )
            for name in ("force", "acceleration")
        }
        by_level = [list(range(a, len(settings), len(levels))) for a in range(len(levels))]
        ln = np.log(W)
        ratio = np.exp(ln - ln.mean(axis=1, keepdims=True))
        return cls(
            [[settings[i] for i in row] for row in by_level],
            [[refills[i] for i in row] for row in by_level],
            channels,
            np.array([ratio[row] for row in by_level]),
        )

    def condition(
        self, a: int, f: int, rng: np.random.Generator, n: int, is_told: bool = True
    ) -> Result:
        """A condition of n refills. is_told: its session states the prediction's refills."""
        setting = self.settings[a][f]
        off = np.exp(LEVEL_ERROR * rng.standard_normal(n))
        W = rng.choice(self.W[a, f], n, replace=False) * off**EXPONENT
        mass, runs = setting.box_mass + setting.bed_mass, []
        for place, (w, level) in enumerate(zip(W, setting.acceleration_set * off, strict=True)):
            phasor = np.array([level + 0j])
            energy = Energy(
                20.0, 40, float(w), np.full(40, w), float(w), 0.0, float(w), mass * phasor, phasor
            )
            runs.append(RunEnergy(f"{setting.id}{place}", setting.id, place, place, energy))
        levels = [setting.acceleration_set * k for k in (0.97, 1.0, 1.03)]
        entry = {
            "acceleration": levels,
            "W_T": [(x / setting.acceleration_set) ** EXPONENT for x in levels],
        }
        refills = {"refills": list(self.refills[a][f])} if is_told else {}
        return evaluate(setting, runs, built(PredictionEntry, {**entry, **refills}), self.channels)

    def session(self, rng: np.random.Generator, n: int, is_told: bool = True) -> list[list[Result]]:
        """A session in which all fills are alike in the mean of ln W, [level][fill]."""
        levels, fills = self.W.shape[:2]
        return [
            [self.condition(a, f, rng, n, is_told) for f in range(fills)] for a in range(levels)
        ]
