"""A box whose loss is known in closed form, in other people's files, and what our import makes of
them.

A rigid mass on a dashpot with Coulomb friction, x = X sin(wt): F = m x'' + c x' + F_c sign(x'), so
that W = pi c w X^2 + 4 F_c X per cycle.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis import AnalysisError, read_session
from daq import open_session
from daq.formats.wave import FormatError
from rig.errors import InputError
from rig.importing.mapping import read_mapping
from rig.importing.to_session import import_records

Array = np.ndarray

RATE, FREQUENCY, LEVEL = 5120.0, 23.41, 5.0  # Hz, Hz, m/s^2
MASS, DASHPOT, COULOMB = 18.0, 31.0, 0.4  # kg, N s/m, N
NOISE_F, NOISE_A = 0.02, 0.002  # N and m/s^2, rms
SECONDS = 4.0
OMEGA = 2 * math.pi * FREQUENCY
GRAVITY = 9.80665


def energy(level: float = LEVEL) -> float:
    """J per cycle."""
    X = level / OMEGA**2
    return math.pi * DASHPOT * OMEGA * X**2 + 4 * COULOMB * X


W = energy()


def motion(t: Array, harmonics: dict[int, float] | None = None) -> tuple[Array, Array]:
    """Force and acceleration at times t (s) without noise; harmonics: further amplitudes of the
    acceleration in m/s^2 by order.
    """
    a, v = np.zeros_like(t), np.zeros_like(t)
    for order, level in {1: LEVEL, **(harmonics or {})}.items():
        # A phase of 0.7 rad: nobody starts a recorder at the start of a cycle.
        phase = order * OMEGA * t + 0.7
        a -= level * np.sin(phase)
        v += level / (order * OMEGA) * np.cos(phase)
    return MASS * a + DASHPOT * v + COULOMB * np.sign(v), a


@dataclass(frozen=True, eq=False)
class Record:
    """Samples in SI units: their times, force and acceleration."""

    t: Array
    F: Array
    a: Array


def record(
    late: float = 0.0, harmonics: dict[int, float] | None = None, t: Array | None = None,
    before: Callable[[Array, Array], tuple[Array, Array]] | None = None, seconds: float = SECONDS,
) -> Record:  # fmt: skip
    """A noisy record. late: s after the acceleration's samples at which those of the force are
    taken. before: changes both signals before the noise.
    """
    rng = np.random.default_rng(3)
    t = np.arange(round(seconds * RATE)) / RATE if t is None else t
    F, a = motion(t + late, harmonics)[0], motion(t, harmonics)[1]
    if before is not None:
        F, a = before(F, a)
    return Record(
        t,
        F + NOISE_F * rng.standard_normal(t.size),
        a + NOISE_A * rng.standard_normal(t.size),
    )


@dataclass(frozen=True)
class Outcome:
    """What came of an import. refused: the sentence, "" for none; flags of the run; fails: the
    verdict does; told: what the session says was taken from the file.
    """

    refused: str = ""
    W: float = math.nan
    U: float = math.nan
    frequency: float = math.nan
    flags: tuple[str, ...] = ()
    fails: bool = False
    told: tuple[str, ...] = ()

    @property
    def silent(self) -> bool:
        """Whether an energy is stated and nothing said against it."""
        return not self.refused and not self.fails

    def near(self, expected: float, times: float = 1.0) -> bool:
        """Whether W is the expected one within some times its U."""
        return abs(self.W - expected) < times * self.U


def outcome(file: Path, mapping: str) -> Outcome:
    """Import a file by the text of a mapping."""
    place, session = file.with_name("map.yaml"), file.with_name("session.h5")
    place.write_text("schema: rig/map/1\nname: known_box\n" + mapping)
    try:
        import_records([file], read_mapping(place), session, overwrite=True)
    except (FormatError, AnalysisError, InputError) as error:
        return Outcome(refused=str(error))
    with open_session(session) as opened:
        report = read_session(opened)
        imported = opened.document("import")[0]
    if not report.conditions:
        return Outcome(refused="; ".join(report.reasons))
    row = report.conditions[0]
    return Outcome(
        "", row.W_exp, row.U_W_exp, row.frequency, row.runs[0].flags, not report.passes,
        tuple(imported["taken_from_the_file"]),
    )  # fmt: skip
