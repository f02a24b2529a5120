"""A run in shaker-coupled drive: a dwell on the exciter, from start-up to the end of the
record.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from daq.chain.source import PhysicalSource
from rig.beds.janssen_stack import Filling
from rig.campaign.one_run.part import STOPS
from rig.catalog.entries import Exciter, Rig
from rig.drive.amplifier_command import Command
from rig.drive.dwell import Dwell, Plan
from rig.drive.electrodynamic import response
from rig.drive.exciter_limits import Demand
from rig.drive.level_control import Target
from rig.protocol.spec import Condition, Drive
from rig.stand.channels import CHANNELS, EXCITER_CHANNELS
from rig.stand.shaker import CoupledStand, Limits

Array = NDArray[np.float64]

SIGNALS = (*CHANNELS, *EXCITER_CHANNELS)
FIRST_GUESS = 0.3
"""Initial command, as a fraction of that needed for the bed rigidly attached. Deliberately low: a
sliding bed needs less, and overshoot can put the bed on another solution branch (hysteresis).
"""

OVERSHOOT = 1.25
"""Level from which a dwell descends if it approaches from above, as a multiple of the
target level.
"""

MARGIN = 2
"""Cycles held after the record: the analyzer's filter looks ahead."""


class Picked:
    """A physical source with the first `count` channels of another one."""

    def __init__(self, source: PhysicalSource, count: int) -> None:
        self.names, self.rate = source.names[:count], source.rate
        self._source, self._count = source, count

    def read(self, n: int) -> Array:
        """Return the next n interval means, shape (count, n)."""
        return self._source.read(n)[: self._count]


@dataclass
class Used:
    """Utilisation of the exciter's limits in the held cycles so far."""

    exciter: Exciter
    current: float = 0.0
    limits: list[Limits] = field(default_factory=list)
    clipped: float = 0.0
    cycles: int = 0

    def add(self, cycles: list[Limits]) -> None:
        """Add cycles."""
        self.clipped += sum(limits.clipped for limits in cycles)
        self.cycles += len(cycles)
        self.limits = [max_of([*self.limits, *cycles])] if cycles else self.limits

    def shares(self, latest: Limits) -> Mapping[str, float]:
        """Return the utilisation of the limits in one cycle.

        The force is rated on the fundamental, because manufacturers rate a sine force; the others
        on peaks.
        """
        force = self.exciter.force_constant * self.current / self.exciter.force_peak
        return {
            "force": force,
            "current": latest.current,
            "voltage": latest.voltage,
            "stroke": latest.stroke,
        }

    def demand(self) -> Demand:
        """Return the largest utilisation, in the form that prescribed motion states."""
        worst = max_of(self.limits)
        return Demand(**self.shares(worst), peak=worst.force, buckling=worst.buckling)


def max_of(found: list[Limits]) -> Limits:
    """Return the largest value of each utilisation; zeros for an empty list."""
    if not found:
        return Limits(*(0.0,) * 6)
    each = (vars(limits).values() for limits in found)
    return Limits(*map(max, zip(*each, strict=True)))


class Dwelling:
    """A condition on the stand in shaker-coupled drive.

    rig : with the actual exciter
    rate : actual intervals per second
    clock : factor of the error of the analyzer's clock
    reading : output of the controller's accelerometer per unit of acceleration
    """

    def __init__(
        self,
        condition: Condition,
        rig: Rig,
        filling: Filling,
        rate: float,
        clock: float = 1.0,
        reading: float = 1.0,
    ) -> None:
        asked = condition.drive
        # The generator shares the analyzer's clock: all frequencies carry its error.
        drive = replace(
            asked,
            frequency=asked.frequency * clock,
            sweep_to=asked.sweep_to and asked.sweep_to * clock,
        )
        self.stand = CoupledStand(
            condition.scene, rig, drive, filling, rate, self._command, SIGNALS
        )
        steady = condition.acquire.settle + condition.acquire.record + MARGIN
        plan = _plan(drive, rig.exciter, self.stand, steady, reading)
        if drive.sweep_to is not None:
            plan = replace(
                plan, sweep=(condition.acquire.settle, condition.acquire.record, drive.sweep_to)
            )
        self.dwell = Dwell(
            plan, rate, SIGNALS.index("acceleration"), SIGNALS.index("current"), self._shares
        )
        self._used = Used(rig.exciter)
        self._seen = 0

    def _command(self, signals: Array | None) -> Command:
        return self.dwell(signals)

    def _shares(self, current: float) -> Mapping[str, float]:
        self._used.current = current
        return self._used.shares(self.stand.limits[-1])

    def ledger(self) -> Array:
        """Return the ledger rows of the held cycles simulated since the last call, shape (cycles,
        len(COUPLED_COLUMNS)).
        """
        rows = self.stand.drain_ledger()
        latest = self.stand.limits[len(self.stand.limits) - len(rows) :]
        # The level control still reads the latest one; all others would grow without limit.
        del self.stand.limits[:-1]
        start, first = self.dwell.steady_from, self._seen
        self._seen += len(rows)
        skipped = len(rows) if start is None else min(max(start - first, 0), len(rows))
        self._used.add(latest[skipped:])
        return rows[skipped:]

    @property
    def demand(self) -> Demand:
        """Utilisation of the exciter's limits in the held cycles."""
        return self._used.demand()

    def scalars(self) -> dict[str, float]:
        """Return the final scalars of the run: utilisation of the limits, and `LEVEL_SCALARS`."""
        loop, used = self.dwell.loop, self._used
        stop = ""
        if loop.status == "limited":
            stop = loop.limit
        elif loop.status == "timed out":
            stop = loop.limit or ("jump" if loop.jumps else "time")
        return {
            **self.demand.scalars(),
            "level_cycles": float(loop.cycles),
            "level_jumps": float(loop.jumps),
            "clipped": used.clipped / max(used.cycles, 1),
            **{f"stopped_by_{name}": float(name == stop) for name in STOPS},
        }


def _plan(drive: Drive, exciter: Exciter, stand: CoupledStand, steady: int, reading: float) -> Plan:
    """Return the dwell for a drive, on the analyzer's clock."""
    orders = drive.frequency * np.arange(1.0, drive.harmonics + 1.0).astype(np.float64)
    box = tuple(complex(x) for x in response(stand.plant, drive.amplifier, orders).acceleration)
    if drive.control == "open":
        limit = exciter.current_peak if drive.amplifier == "current" else exciter.voltage_peak
        return Plan(drive.frequency, complex(drive.command * limit), (), steady, box[:1], reading)
    whole = replace(stand.plant, box=stand.plant.box + stand.bed.mass - stand.bed.bonded)
    # Response with the whole bed rigidly attached: the heaviest case, for the first command.
    bonded = complex(response(whole, drive.amplifier, drive.frequency).acceleration[0])
    target = Target(drive.acceleration, timeout=drive.timeout)
    above = (
        (Target(OVERSHOOT * drive.acceleration, timeout=drive.timeout),)
        if drive.approach == "above"
        else ()
    )
    guess = FIRST_GUESS * drive.acceleration / abs(bonded)
    return Plan(drive.frequency, complex(guess), (*above, target), steady, box, reading)
