"""The exciter in the loop against real time: 680 rows, four levels, default step, one core."""

import statistics
import time
from typing import Any

import numpy as np

from rig.beds.janssen_stack import refill
from rig.benchmarks.timing import spread
from rig.catalog.rig_file import load_rig
from rig.drive.amplifier_command import Command
from rig.drive.dwell import phasors
from rig.protocol.spec import Drive, Grains, Scene
from rig.stand.shaker import CoupledStand

Row = dict[str, Any]

FREQUENCY = 20.0
RATE = 4096 * FREQUENCY
SETTLED = 12
"""Cycles from rest, not counted."""

CURRENTS = (2.9, 4.9, 7.5, 16.0)
"""Current, A peak, for about 1, 2.3, 3.3 and 5 m/s2."""


def coupled(rounds: int, quick: bool) -> list[Row]:
    """Measure rig time over CPU time of this thread at each level, over cycles of some refills, in
    turn.
    """
    rig, scene = load_rig("paper"), Scene(grains=Grains(density=7900.0))
    cycles = 8 if quick else 20
    stands: dict[float, list[CoupledStand]] = {}
    for current in CURRENTS:
        stands[current] = []
        for seed in range(2):
            filling = refill(scene, rig, np.random.default_rng(seed))
            stand = CoupledStand(
                scene, rig, Drive(mode="shaker", amplifier="current"), filling, RATE
            )
            stand.advance(Command((complex(current),), FREQUENCY, SETTLED))
            stands[current].append(stand)
    faster: dict[float, list[float]] = {current: [] for current in CURRENTS}
    levels: dict[float, list[float]] = {current: [] for current in CURRENTS}
    for _ in range(max(rounds, 3)):
        for current, tested in stands.items():
            times = []
            for stand in tested:
                for _ in range(cycles):
                    start = time.thread_time()
                    signals = stand.advance(Command((complex(current),), FREQUENCY))
                    times.append(time.thread_time() - start)
                    levels[current].append(abs(phasors(signals[1], 0, RATE, FREQUENCY, 1)[0]))
            faster[current].append(1.0 / FREQUENCY / statistics.median(times))
    return [
        {
            "kind": "coupled",
            "current": current,
            "level": statistics.mean(levels[current]),
            "rows": int(stands[current][0].bed.band.size),
            "times_faster": spread(faster[current]),
            "failure": None,
        }
        for current in CURRENTS
    ]
