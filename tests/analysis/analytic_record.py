"""A session in memory, made of exact signals: what the analysis reads, without any of the product's
simulators.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

RATE, FREQUENCY = 10240.0, 20.0
OMEGA = 2 * np.pi * FREQUENCY
FILTER_DELAY = 39 - 1 / 16
BOX_MASS, GAUGE_MASS, MOVING_MASS = 11.9, 0.02, 0.5


@dataclass(frozen=True)
class Facts:
    name: str
    unit: str
    model: str = "analytic"
    sensitivity: float = 1.0
    time_constant: float | None = None
    time_constant_spread: float = 0.0
    filter_delay: float = FILTER_DELAY
    skew: float = 0.0
    calibration_U: float = 0.0
    gain_tolerance: float = 0.0
    clock_ppm: float = 0.0
    noise_rms: float = 0.0
    corner: float = 0.0
    corner_tolerance: float = 0.0
    skew_tolerance: float = 0.0
    flicker: float = 0.0
    full_scale: float = 0.0
    linearity: float = 0.0
    clips_at: float = 0.0
    scale: float = 0.0

    @property
    def time_constants(self) -> tuple[float, ...]:
        return () if self.time_constant is None else (self.time_constant,)


IDEAL = {"force": Facts("force", "N"), "acceleration": Facts("acceleration", "m/s^2")}
NOMINAL = {
    "force": Facts(
        "force",
        "N",
        "208C03",
        2.248e-3,
        2000.0,
        0.1,
        calibration_U=0.01,
        gain_tolerance=0.003,
        clock_ppm=50.0,
        noise_rms=0.02,
    ),
    "acceleration": Facts(
        "acceleration",
        "m/s^2",
        "352C33",
        0.0102,
        1.6,
        0.1,
        calibration_U=0.01,
        gain_tolerance=0.003,
        clock_ppm=50.0,
        noise_rms=5e-4,
    ),
}


@dataclass(frozen=True)
class Run:
    name: str
    condition: str
    repeat: int
    order: int
    samples: int
    complete: bool = True
    flags: int = 0
    rate: float = RATE


@dataclass(frozen=True)
class Samples:
    samples: np.ndarray
    flags: int = 0


@dataclass(frozen=True)
class KnownTruth:
    ledgers: dict[str, tuple[tuple[str, ...], np.ndarray]]
    documents: dict[str, Any] = field(default_factory=dict)

    def ledger(
        self, run: str, start: int = 0, stop: int | None = None
    ) -> tuple[tuple[str, ...], np.ndarray]:
        columns, rows = self.ledgers[run]
        return columns, rows[start:stop]

    def document(self, name: str) -> Any:
        return self.documents.get(name)


@dataclass(frozen=True)
class AnalyticRecord:
    """The record API over arrays; `signals` holds (force, acceleration) by run."""

    runs: tuple[Run, ...]
    conditions: dict[str, dict[str, Any]]
    channels: dict[str, Facts]
    signals: dict[str, tuple[np.ndarray, np.ndarray]]
    truth: KnownTruth | None = None
    documents: dict[str, Any] = field(default_factory=dict)
    block_flags: int = 0
    synthetic: bool = True

    def run(self, name: str) -> Run:
        return next(run for run in self.runs if run.name == name)

    def signal(self, run: str, name: str, start: int = 0, stop: int | None = None) -> Samples:
        samples = self.signals[run][name == "acceleration"][start:stop]
        assert len(samples) == (stop or len(self.signals[run][0])) - start
        return Samples(samples, self.block_flags)

    def document(self, name: str) -> Any:
        return self.documents.get(name)

    def blocks(self, run: str) -> np.ndarray:
        """One block, one sample in a hundred of the force at the rail where the flags say so."""
        samples = self.run(run).samples
        dtype = [
            ("start", "<u8"),
            ("count", "<u4"),
            ("flags", "<u2", (2,)),
            ("clipped", "<u4", (2,)),
        ]
        return np.array([(0, samples, (self.block_flags,) * 2, (samples // 100, 0))], dtype=dtype)

    def scalars(self, run: str) -> dict[str, float]:
        return {"use_force": 0.5} if run else {}


def condition(name: str, **changes: Any) -> dict[str, Any]:
    """A condition as a campaign writes it."""
    return {
        "id": name,
        "material": "stainless",
        "density": 7900.0,
        "diameter": 0.004,
        "fill": 0.85,
        "bed": "layers",
        "drive": "prescribed",
        "axis": "horizontal",
        "bed_mass": 38.1,
        "carried": False,
        "frequency": FREQUENCY,
        "acceleration_set": 5.0,
        "settle_cycles": 10,
        "record_cycles": 40,
        "samples_per_cycle": RATE / FREQUENCY,
        "box_mass": BOX_MASS,
        "gauge_mass": GAUGE_MASS,
        "moving_mass": MOVING_MASS,
        "losses": ["noise", "air"],
        **changes,
    }


def drive_time(samples: int, rate: float = RATE, delay: float = FILTER_DELAY) -> np.ndarray:
    """Drive time of each sample in s."""
    return (np.arange(samples) - delay) / rate


def motion(t: np.ndarray, a0: float, frequency: float = FREQUENCY) -> tuple[np.ndarray, np.ndarray]:
    """Acceleration -a0 sin(wt) and velocity (a0/w) cos(wt)."""
    w = 2 * np.pi * frequency
    return -a0 * np.sin(w * t), a0 / w * np.cos(w * t)


def dashpot_energy(c: float, a0: float, frequency: float = FREQUENCY) -> float:
    """pi c w X^2 with X = a0 / w^2."""
    w = 2 * np.pi * frequency
    return np.pi * c * w * (a0 / w**2) ** 2


@dataclass(frozen=True)
class Bench:
    """What the synthetic sessions below are made of.

    gains and turn (rad) are the instruments' hidden errors: true scale factors of force and
    acceleration, phase lead of the acceleration beyond what its certified pole makes. noise: rms in
    N and m/s^2.
    """

    channels: dict[str, Facts] = field(default_factory=lambda: dict(IDEAL))
    gains: tuple[float, float] = (1.0, 1.0)
    turn: float = 0.0
    noise: tuple[float, float] = (0.0, 0.0)
    level_error: float = 0.0
    repeats: int = 4
    samples: int = 51 * 512


def session(
    conditions: list[dict[str, Any]],
    loss: Any,
    bench: Bench,
    rng: np.random.Generator,
    **documents: Any,
) -> AnalyticRecord:
    """A session whose bed is a dashpot of loss(condition, repeat) N s/m beside rigid mass, read by
    a bench.
    """
    runs, signals, ledgers = [], {}, {}
    t = drive_time(bench.samples)
    for entry in conditions:
        tau = bench.channels["acceleration"].time_constant
        lead = bench.turn + (0.0 if tau is None else np.arctan(1 / (OMEGA * tau)))
        mass = entry["box_mass"] + entry["gauge_mass"] + entry["bed_mass"]
        for repeat in range(bench.repeats):
            a0 = entry["acceleration_set"] * (1 + bench.level_error * rng.standard_normal())
            c = loss(entry, repeat)
            acceleration, velocity = motion(t, a0)
            turned, _ = motion(t + lead / OMEGA, a0)
            name = f"run_{len(runs) + 1:04d}"
            force = (mass * acceleration + c * velocity) * bench.gains[0]
            turned = turned * bench.gains[1]
            if any(bench.noise):
                force = force + bench.noise[0] * rng.standard_normal(t.size)
                turned = turned + bench.noise[1] * rng.standard_normal(t.size)
            runs.append(Run(name, entry["id"], repeat, len(runs) + 1, t.size))
            signals[name] = (force, turned)
            row = [dashpot_energy(c, a0), 0.0, 0.0]
            ledgers[name] = (("W_viscous", "dKE_bed", "closure"), np.tile(row, (50, 1)))
    table = {entry["id"]: entry for entry in conditions}
    return AnalyticRecord(
        tuple(runs), table, bench.channels, signals, KnownTruth(ledgers), documents
    )


def prediction_for(
    conditions: list[dict[str, Any]], energy: Any, u_rel: float = 0.0
) -> dict[str, Any]:
    """A prediction document from energy(condition, a0) in J."""
    entries = {}
    for entry in conditions:
        levels = [entry["acceleration_set"] * factor for factor in (0.97, 1.0, 1.03)]
        W = [energy(entry, a) for a in levels]
        entries[entry["id"]] = {
            "acceleration": levels,
            "W_T": W,
            "W_f": [0.6 * w for w in W],
            "W_c": [0.4 * w for w in W],
            "u_rel": u_rel,
            "W_T_as_printed": 2 * W[1],
            "bound": 3 * W[1],
            "period": 1,
            "periodic_share": 1.0,
        }
    return {"conditions": entries}
