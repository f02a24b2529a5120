"""A small session for the session tests: two channels, two conditions, three runs, every kind of
content.
"""

import numpy as np

from daq.chain.block import Block
from daq.chain.channel import AnalyzerSpec, Channel, ChannelInfo, TransducerSpec, channel_info
from daq.session.plan import RunPlan, SessionPlan

RATE = 10240.0
SAMPLES = 20000  # more than one chunk
COLUMNS = ("W_f", "W_c")

FORCE = TransducerSpec("208C03", "force", "N", 2.248e-3, 2200.0, 2000.0, 0.1, 0.02, 1e4, 0.01)
ACCELERATION = TransducerSpec(
    "DC", "acceleration", "m/s^2", 0.0102, 490.0, None, 0.1, 1.5e-3, 1e4, 0.01
)
ANALYZER = AnalyzerSpec("INV-3118", (51200.0, RATE))


def infos() -> tuple[ChannelInfo, ...]:
    channels = (
        Channel("force", FORCE, 10.0, "F1", "+x", "2026-01-31"),
        Channel("acceleration", ACCELERATION, 1.0, "A1", "+x", coupling="IEPE"),
    )
    return tuple(channel_info(channel, ANALYZER, RATE, 38.9375) for channel in channels)


def plan(samples: int = SAMPLES, runs: int = 3, blocks: int = 8) -> SessionPlan:
    return SessionPlan(
        rate=RATE,
        channels=infos(),
        runs=tuple(
            RunPlan(
                f"run_{i:04d}",
                f"c{1 + i % 2:02d}",
                i // 2 + 1,
                i,
                samples,
                samples // 5,
                blocks,
                "2026-11-22T00:00Z",
            )
            for i in range(1, runs + 1)
        ),
        conditions=({"id": "c02", "fill": 0.5}, {"id": "c01", "fill": 0.9}),
        protocol_text="schema: rig/protocol/1\nname: größe\n",
        protocol={"schema": "rig/protocol/1", "name": "größe"},
        documents={
            "prediction": {"conditions": {"c01": {"W_T": [0.1, 0.2]}}},
            "rig": {"name": "paper"},
        },
        truth_documents={"instruments": {"force": {"sensitivity": 2.25e-3}}},
        ledger_columns=COLUMNS,
        ledger_cycles=4,
        scalars=("force_use", "stroke_use"),
    )


def codes(samples: int = SAMPLES, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.integers(-(2**23), 2**23, (2, samples), dtype=np.int32)


def block(start: int, values: np.ndarray, flags: tuple[int, int] = (0, 0)) -> Block:
    return Block(start, values, np.array(flags, np.uint16), np.array([0, 3], np.uint32), False)
