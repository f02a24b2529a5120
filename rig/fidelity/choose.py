"""`fidelity: auto` for one condition: number of rows, settling and record, and the parts that are
not simulated.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from daq.random_streams import stream
from rig.beds.janssen_stack import Filling, nominal, refill
from rig.catalog.entries import Rig
from rig.catalog.entries_by_name import IDEAL
from rig.drive.losses import LOST
from rig.drive.waveform import Waveform, waveform
from rig.fidelity.choice import FidelityChoice
from rig.fidelity.lengths import LengthChoice, choose_lengths
from rig.fidelity.pilot import Pilot, PilotRun, rows_pilot
from rig.fidelity.rows import PILOT_CYCLES, RowsChoice, choose_rows
from rig.fidelity.scene_rows import resolved_rows, with_rows
from rig.kernels.rows.many_rows import HISTORY
from rig.protocol.spec import RIGID_BEDS, Acquire, Condition, Protocol, Scene
from rig.stand.gas import LEAST_SHARE, share_of_weight
from rig.stand.ledger import COLUMNS
from rig.stand.prescribed import CHUNK_CYCLES, Stand
from rig.theory.total import AVERAGED_CYCLES

TOLERANCE = 0.01
"""Relative error of W per cycle if a protocol gives none."""

"""Beds that are the same in every cycle: there is nothing to settle."""

LONGER = 2
"""Factor by which the pilot run is extended if the tolerance is not met at first."""

POURINGS = 2
"""Random refills in the pilot runs in addition to the nominal filling, if runs are refilled."""

MOST_RUNS = 16
"""Most runs of a bed without rows that get a pilot run each."""

EDGES = 64
"""Sampling edges per cycle of a stand for energies only, which are computed at the events."""

FULL_SETTLE, FULL_RECORD = 64, 256
"""Fully resolved: settling over the longest period that is looked for, and a record four times as
long.
"""


@dataclass(frozen=True)
class Asked:
    """Requirements of a protocol on every condition.

    tolerance : relative error of a condition's W per cycle, mean over its runs, against the fully
        resolved scene
    seed, runs : of the protocol
    poured : whether each run has a refill of its own
    """

    tolerance: float
    seed: int
    runs: int
    poured: bool

    @classmethod
    def of(cls, protocol: Protocol) -> "Asked":
        """Return the requirements of a protocol with `fidelity: auto`."""
        tolerance = TOLERANCE if protocol.tolerance is None else protocol.tolerance
        return cls(tolerance, protocol.seed, protocol.repeats.n, protocol.repeats.refill)

    def drawn(self, condition: Condition) -> int:
        """Return the number of runs with random draws of their own; 0 if all are alike."""
        return self.runs if self.poured or condition.drive.imperfection != "none" else 0


@dataclass(frozen=True)
class Noise:
    """Effect of the instruments on the W of one condition.

    one_cycle : standard deviation due to their noise in a record of one cycle, J
    detect : energy below which nothing is claimed, J
    settle : cycles until the acquisition is settled
    """

    one_cycle: float = 0.0
    detect: float = 0.0
    settle: int = 1


def choose(
    condition: Condition, rig: Rig, asked: Asked, noise: Noise, losses: float
) -> FidelityChoice:
    """Return the cheapest rows, settling and record within the tolerance; `losses` : losses of the
    box, J per cycle.
    """
    scene, drive, acquire = condition.scene, condition.drive, condition.acquire
    rows = None
    if scene.bed == "layers":
        rows = choose_rows(scene, rig, drive, asked.tolerance, asked.drawn(condition))
        scene = with_rows(scene, rows.rows)
    allowed = asked.tolerance - (rows.error if rows else 0.0)
    planning = rows.planning if rows else 0
    pilots: list[Pilot] = []
    first = rows.cycles if rows else PILOT_CYCLES[0]
    pilot_runs: list[PilotRun] = []
    if rows is None and scene.bed not in RIGID_BEDS:
        pilot_runs = _pilots_of_runs(condition, rig, asked)
    elif rows and rows.pilot.W > 0.0:
        pilot_runs = [
            partial(rows_pilot, scene, rig, drive, filling)
            for filling in _fillings(scene, rig, asked, condition)
        ]
    for cycles in (first, LONGER * first):
        # The first pilot run is the one that chose the rows: it is not repeated.
        known = [rows.pilot] if rows and pilot_runs and cycles == first else []
        pilots = known + [pilot_run(cycles) for pilot_run in pilot_runs[len(known) :]]
        planning += sum(pilot.simulated for pilot in pilots[len(known) :])
        scale = max((pilots[0].W if pilots else 0.0) + losses, noise.detect)
        relative = 2.0 * noise.one_cycle / scale / asked.runs**0.5 if scale > 0.0 else 0.0
        lengths = choose_lengths(
            pilots, allowed, relative, noise.settle, acquire.settle + acquire.record
        )
        # Longer pilot runs help only if the window, not the noise, limits the accuracy.
        if lengths.error <= allowed or not pilots or lengths.noise > allowed:
            break
    return _choice(
        condition, asked.tolerance, rows, lengths, _skipped(condition, rig, rows), planning
    )


def resolved(
    protocol: Protocol, conditions: Sequence[Condition], rig: Rig
) -> tuple[tuple[Condition, int], ...]:
    """Return a protocol's conditions with the rows that `choose` would give them, and the cycles
    over which W_T averages rows without a period.

    For uses that need no record.
    """
    if protocol.fidelity != "auto":
        return tuple((condition, AVERAGED_CYCLES) for condition in conditions)
    asked = Asked.of(protocol)
    return tuple(_with_found_rows(condition, rig, asked) for condition in conditions)


def _with_found_rows(condition: Condition, rig: Rig, asked: Asked) -> tuple[Condition, int]:
    if condition.scene.bed != "layers":
        return condition, AVERAGED_CYCLES
    found = choose_rows(
        condition.scene, rig, condition.drive, asked.tolerance, asked.drawn(condition)
    )
    return replace(condition, scene=with_rows(condition.scene, found.rows)), _averaged(found)


def _averaged(rows: RowsChoice | None) -> int:
    """Return the cycles over which W_T averages rows without a period."""
    return rows.cycles - HISTORY if rows else AVERAGED_CYCLES


def _fillings(scene: Scene, rig: Rig, asked: Asked, condition: Condition) -> Sequence[Filling]:
    """Return the fillings of the pilot runs: the nominal one and, if runs are refilled, random
    ones.
    """
    rng = stream(asked.seed, condition.seed_key, "fidelity")
    drawn = [refill(scene, rig, rng) for _ in range(POURINGS)] if asked.poured else []
    return [nominal(scene, rig), *drawn]


def _pilots_of_runs(condition: Condition, rig: Rig, asked: Asked) -> list[PilotRun]:
    """Return pilot runs for the runs of a bed without rows, with the waveform and filling that each
    of them draws.

    A single mass may settle in a few cycles on an exact sine and wander for hundreds on one that
    deviates by 0.3 %.
    """
    scene, drive = condition.scene, condition.drive
    if not asked.drawn(condition):
        exact = Waveform(drive.frequency, drive.acceleration)
        return [partial(stand_pilot, scene, rig, exact, nominal(scene, rig))]
    found: list[PilotRun] = []
    for repeat in range(1, min(asked.runs, MOST_RUNS) + 1):
        draw = partial(stream, asked.seed, condition.seed_key, str(repeat))
        rng = None if drive.imperfection == "none" else draw("drive")
        motion = waveform(drive, rig.level_error, rig.third_harmonic, rng)
        filling = refill(scene, rig, draw("refill")) if asked.poured else nominal(scene, rig)
        found.append(partial(stand_pilot, scene, rig, motion, filling))
    return found


def _choice(
    condition: Condition,
    tolerance: float,
    rows: RowsChoice | None,
    lengths: LengthChoice,
    skipped: tuple[str, ...],
    planning: int,
) -> FidelityChoice:
    written = (condition.scene.layers.rows, condition.acquire.settle, condition.acquire.record)
    resolved = (resolved_rows(condition.scene), FULL_SETTLE, FULL_RECORD)
    chosen = (rows.rows if rows else 0, lengths.settle, lengths.record)
    flowing = rows.pilot.flowing if rows else 0
    counts = {"auto": chosen, "written": written, "resolved": resolved}
    return FidelityChoice(
        tolerance=tolerance,
        rows=rows.rows if rows else None,
        settle=lengths.settle,
        record=lengths.record,
        written=written,
        resolved=resolved,
        error_rows=rows.error if rows else 0.0,
        error_window=lengths.window,
        error_noise=lengths.noise,
        scatter=rows.scatter if rows else 0.0,
        scatter_resolved=rows.scatter_resolved if rows else 0.0,
        averaged=_averaged(rows),
        skipped=skipped,
        row_cycles={name: flowing * a * (s + r) for name, (a, s, r) in counts.items()}
        | {"planning": planning},
    )


def _skipped(condition: Condition, rig: Rig, rows: RowsChoice | None) -> tuple[str, ...]:
    """Return the parts that the run leaves out because they would have no effect."""
    scene, drive = condition.scene, condition.drive
    said = {
        "empty": "bed: the box is empty",
        "loop_back": "bed: none, one voltage at all inputs",
        "locked": "bed: bonded to the box, carried as mass",
        "dashpot": "bed: a coefficient, nothing in it settles",
    }
    found = [said[scene.bed]] if scene.bed in said else []
    if rows is not None:
        still = rows.pilot.layers - rows.pilot.flowing
        if rows.pilot.layers == 0:
            found.append("bed: no grains")
        elif still:
            found.append(
                f"{still} of {rows.pilot.layers} layers: below their threshold or without room, carried as mass"
            )
        if rows.pilot.W > 0.0:
            found.append(
                f"rows that repeat themselves, {100 * rows.pilot.repeating:.3g} % of W: replayed"
            )
    if "gas" in scene.losses:
        share = share_of_weight(scene, rig, drive.acceleration, drive.frequency)
        found += [f"gas: {100 * share:.2g} % of the bed's weight"] if share <= LEAST_SHARE else []
    return (*found, *_ideal(condition.acquire))


def _ideal(acquire: Acquire) -> tuple[str, ...]:
    """Return the ideal components, whose errors are left out."""
    parts = {
        "analyzer": (acquire.analyzer, "noise, gain error, skew, clock"),
        "force sensor": (acquire.sensors.force, "noise, pole, calibration error"),
        "acceleration sensor": (acquire.sensors.acceleration, "noise, pole, calibration error"),
    }
    return tuple(
        f"{name}: ideal, no {what}" for name, (model, what) in parts.items() if model == IDEAL
    )


def stand_pilot(scene: Scene, rig: Rig, motion: Waveform, filling: Filling, cycles: int) -> Pilot:
    """Run a pilot of any bed on a stand with few sampling edges: the steady energy is the mean of
    the later half.
    """
    stand = Stand(scene, rig, motion, filling, EDGES * motion.frequency)
    for _ in range(-(-cycles // CHUNK_CYCLES)):
        stand.advance()
    ledger = stand.drain_ledger()[:cycles]
    lost = ledger[:, [COLUMNS.index(name) for name in LOST]].sum(axis=1)
    work = ledger[:, COLUMNS.index("W_gauge")] - lost
    steady = float(work[cycles // 2 :].mean())
    return Pilot(np.array([[steady]]), work, 0, 0, 1.0, 0.0, cycles)
