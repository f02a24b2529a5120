"""A measured record without a laboratory: a box on a dashpot and a hysteretic spring, in closed
form, with noise.

Needs numpy only and nothing of this project. The box moves as x(t) = X sin(wt); a force gauge sees

    F = m x'' + c x' + (k h / w) x'

m rigid mass, c a dashpot, k h the loss stiffness of a hysteretic (structural) damper, whose loss
per cycle does not depend on frequency. So W = pi c w X^2 + pi k h X^2 per cycle, exactly. The drive
is at 19.87 Hz, which makes no whole number of samples per cycle at 5120 Hz; the record begins
before the shaker is steady; both channels carry white noise.

    python make_record.py [FOLDER]     writes box_1.csv, box_2.csv, box_3.csv and empty.csv
"""

import sys
from pathlib import Path

import numpy as np

RATE, FREQUENCY = 5120.0, 19.87  # Hz
OMEGA = 2 * np.pi * FREQUENCY
LEVEL = 4.0  # m/s^2
MASS, DASHPOT, LOSS_STIFFNESS = 31.0, 24.0, 900.0  # kg, N s/m, N/m
EMPTY_MASS = 12.0
NOISE = {"force": 0.05, "acceleration": 0.004}  # N and m/s^2, rms
SECONDS, START_UP = 4.0, 0.4  # s


def energy(level: float, dashpot: float, loss_stiffness: float) -> float:
    """J per cycle."""
    amplitude = level / OMEGA**2
    return float(np.pi * amplitude**2 * (dashpot * OMEGA + loss_stiffness))


def record(mass: float, dashpot: float, loss_stiffness: float, seed: int) -> np.ndarray:
    """Time in s, force in N, acceleration in g; the level comes up over START_UP."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(SECONDS * RATE)) / RATE
    rise = np.minimum(t / START_UP, 1.0)
    phase = OMEGA * t + rng.uniform(0, 2 * np.pi)  # nobody starts a recorder at a cycle's start
    acceleration, velocity = -LEVEL * rise * np.sin(phase), LEVEL / OMEGA * rise * np.cos(phase)
    force = mass * acceleration + (dashpot + loss_stiffness / OMEGA) * velocity
    force += NOISE["force"] * rng.standard_normal(t.size)
    acceleration += NOISE["acceleration"] * rng.standard_normal(t.size)
    return np.stack([t, force, acceleration / 9.80665], axis=1)


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for number in (1, 2, 3):
        _write(folder / f"box_{number}.csv", record(MASS, DASHPOT, LOSS_STIFFNESS, number))
    _write(folder / "empty.csv", record(EMPTY_MASS, 0.0, 0.0, 4))
    print(
        f"W = {energy(LEVEL, DASHPOT, LOSS_STIFFNESS):.6e} J per cycle in box_1 to box_3, 0 in empty"
    )


def _write(path: Path, rows: np.ndarray) -> None:
    np.savetxt(path, rows, fmt="%.9e", delimiter=";", header="t [s];F [N];a [g]", comments="")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("."))
