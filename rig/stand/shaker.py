"""The stand in shaker-coupled drive: amplifier, exciter, box and bed interact; outputs are
force and acceleration.
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from rig.beds.coupled_step import TWO_WAY, TwoWay
from rig.beds.janssen_stack import Filling
from rig.catalog.entries import Rig
from rig.drive.amplifier_command import Command
from rig.drive.electrodynamic import VA, VB, XA, XB, I, Plant, Propagator, V, X, propagator, steady
from rig.drive.losses import Losses
from rig.drive.waveform import Waveform
from rig.kernels.rows import with_exciter as kernel
from rig.kernels.rows.coupled_step import Pull
from rig.protocol.spec import Drive, Scene
from rig.stand.box import box_mass, losses_of
from rig.stand.gas import gas_damping
from rig.stand.ledger import COUPLED_COLUMNS, SPENT

Array = NDArray[np.float64]

SIGNALS = ("force", "acceleration", "voltage", "current")
"""Available signals: gauge force (N), box acceleration (m/s^2), amplifier voltage (V), coil current
(A).
"""

LEAST_INTERVALS = 4000
"""Least number of intervals per cycle; coarser sampling is subdivided."""

LARGEST_ANGLE = 0.25
"""Largest phase, rad, of the mode of box and armature on the stinger per interval.

The quadrature error of its energy grows with the fourth power of it. Steps are not shortened by it.
"""

STEPS = 512
LONGEST_STEP = 1e-4
"""Steps per cycle, and the longest one, s."""

Driver = Callable[[Array | None], Command]
"""Returns the next command from the signals of the latest one, shape (channels, intervals); None at
the start.
"""


@dataclass(frozen=True)
class Limits:
    """Utilisation of the exciter's limits in one cycle (1 = at the limit).

    clipped : fraction of the cycle in which the amplifier did not follow its command
    """

    voltage: float
    current: float
    stroke: float
    force: float
    buckling: float
    clipped: float


class CoupledStand:
    """A `PhysicalSource`: interval means of force and acceleration of a box that is moved by
    exciter and bed.

    `names` selects from SIGNALS. Commands are passed one by one to `advance`, or come from a
    `driver` when the stand is read. Everything is at rest at the start. Memory is constant.
    """

    def __init__(
        self,
        scene: Scene,
        rig: Rig,
        drive: Drive,
        filling: Filling,
        rate: float,
        driver: Driver | None = None,
        names: tuple[str, ...] = ("force", "acceleration"),
        refine: int = 1,
    ) -> None:
        self.rate = rate
        self.names = names
        self.bed: TwoWay = TWO_WAY[scene.bed](scene, rig, filling)
        motion = Waveform(drive.frequency, drive.acceleration)
        gas = gas_damping(scene, rig, filling, motion) if "gas" in scene.losses else 0.0
        carried = box_mass(scene.cavity, rig.wall_density) + rig.gauge_mass + self.bed.mass
        self.losses: Losses = losses_of(scene, rig, carried, drive.frequency, gas)
        self._exciter = rig.exciter
        self._by_current = drive.amplifier == "current"
        self._head = drive.accelerometer == "exciter"
        cords = self.losses.cords / (2.0 * np.pi * drive.frequency)
        self._viscous = np.array([self.bed.damping, self.losses.noise, self.losses.gas, cords])
        box = box_mass(scene.cavity, rig.wall_density) + self.bed.bonded
        self.plant = Plant.of(
            rig.exciter, box, rig.gauge_mass, drive.gauge, float(self._viscous.sum())
        )
        self._ringing = float(
            np.sqrt(self.plant.stinger * (1.0 / self.plant.armature + 1.0 / self.plant.box))
        )
        self._driver = driver
        self._refine = refine
        self._grids: dict[tuple[int, int], Propagator] = {}
        self._y = np.zeros(kernel.STATES)
        rows = self.bed.band.size
        self._w, self._u = np.full(rows, self.bed.velocity), np.full(rows, self.bed.start)
        # A row at rest at the wall leans on it: the wall may push it without limit.
        leans = (self._u == 0.0) & (self._w == 0.0)
        self._lo, self._hi = -self.bed.band, np.where(leans, np.inf, self.bed.band)
        self._machine = kernel.Machine(
            **asdict(self.plant),
            voltage_peak=rig.exciter.voltage_peak,
            current_peak=rig.exciter.current_peak,
            is_current=self._by_current,
            interval=0.0,
        )
        # The weight of the rows along the axis is held by the support of the box.
        resting = -self.bed.row_mass * rows * self.bed.pull
        self._around = Pull(
            self.bed.row_mass,
            self.bed.restitution,
            self.bed.pull,
            self.plant.box,
            self.losses.air,
            self.losses.guide,
            resting,
        )
        self._feed = kernel.Feed(self._by_current, np.nan)
        self._phasors: tuple[complex, ...] = ()
        self._start = 0.0
        self._beyond = 0.0
        self._done = 0
        self._waiting = np.zeros((len(names), 0))
        self._latest: Array | None = None
        self._rows: list[Array] = []
        self.limits: list[Limits] = []

    @property
    def bed_mass(self) -> float:
        """Mass of the grains in this filling, kg."""
        return self.bed.mass

    @property
    def state(self) -> Array:
        """Positions (m) and velocities (m/s) of armature, body and box in turn, and the current
        (A).
        """
        return self._y.copy()

    def begin(self, command: Command) -> None:
        """Start in the steady state of the command's final phasors, with the rows riding along (not
        at rest).

        This saves the settling of the exciter's slow modes. Raises ValueError on a stand that has
        moved.
        """
        if self._done:
            raise ValueError("the stand has moved already")
        order = np.arange(1.0, len(command.phasors) + 1.0)
        unit = steady(
            self.plant, "current" if self._by_current else "voltage", order * command.frequency
        )
        self._y[:] = (unit @ np.asarray(command.phasors)).real
        self._w[:] = self._y[V] + self.bed.velocity
        self._phasors = command.phasors

    @property
    def bed_momentum(self) -> float:
        """Momentum of the rows, N s; mass bonded to the box counts as box."""
        return float(self.bed.row_mass * self._w.sum())

    def read(self, n: int) -> Array:
        """Return the next n interval means, shape (channels, n); commands come from the driver."""
        if self._driver is None:
            raise ValueError("a stand without a driver has no next command")
        ready = [self._waiting]
        size = self._waiting.shape[1]
        while size < n:
            self._latest = self.advance(self._driver(self._latest))
            ready.append(self._latest)
            size += self._latest.shape[1]
        joined = np.concatenate(ready, axis=1)
        self._waiting = joined[:, n:]
        return joined[:, :n]

    def drain_ledger(self) -> Array:
        """Return the ledger rows of the cycles simulated since the last call, shape (cycles,
        len(ledger.COUPLED_COLUMNS)).
        """
        rows = np.concatenate([np.zeros((0, len(COUPLED_COLUMNS))), *self._rows])
        self._rows = []
        return rows

    def advance(self, command: Command) -> Array:
        """Return the interval means of one command, shape (channels, intervals); cycle n owns the
        edges in (n, n + 1].
        """
        ends = [
            int(np.floor((self._start + command.time_of(n + 1.0)) * self.rate + 1e-6))
            for n in range(command.cycles)
        ]
        out = [
            self._cycle(command, first, last)
            for first, last in zip([self._done, *ends[:-1]], ends, strict=True)
        ]
        self._start += command.duration
        self._done = ends[-1]
        self._phasors = command.phasors
        return np.concatenate(out, axis=1)

    def _cycle(self, command: Command, first: int, last: int) -> Array:
        """Return the signals between two edges."""
        fastest = max(command.frequency, command.last_frequency)
        parts = self._refine * int(
            np.ceil(max(LEAST_INTERVALS * fastest, self._ringing / LARGEST_ANGLE) / self.rate)
        )
        fine = self.rate * parts
        steps = int(min(1.0 / (fastest * STEPS), LONGEST_STEP) * fine / self._refine)
        interval = 1.0 / fine
        time = np.arange(first * parts, last * parts + 1) * interval - self._start
        told = command.values(self._phasors, np.clip(time, 0.0, command.duration))
        limit = self._exciter.current_peak if self._by_current else self._exciter.voltage_peak
        asked = np.clip(told, -limit, limit)
        before = self._energies()
        grid = self._grid(parts, max(steps, 1), interval)
        self._feed, signals, accounts = kernel.stretch(
            self._machine._replace(interval=interval), self._around, self._feed,
            grid.phi, grid.now, grid.next, grid.thrust, asked,
            self._y, self._w, self._u, self._lo, self._hi, self.bed.band, self.bed.clearance,
        )  # fmt: skip
        clipped = float(np.mean((signals[:-1, kernel.LIMITED] > 0.0) | (asked[1:] != told[1:])))
        # Half of an impact at the last edge belongs to the first interval of the next cycle.
        signals[0, kernel.SPEED] += self._beyond
        self._beyond = float(signals[-1, kernel.SPEED])
        signals = signals[:-1]
        self._rows.append(
            self._account(accounts, float(time[-1] - time[0]), before, self._energies())
        )
        self.limits.append(self._used(accounts, clipped))
        if parts > 1:
            signals = signals.reshape(-1, parts, kernel.SIGNALS).sum(axis=1)
        means = signals.T * self.rate
        named = {
            "force": means[kernel.MOMENTUM] + self.plant.read_mass * means[kernel.GAUGE_MASS],
            "acceleration": means[kernel.GAUGE_MASS if self._head else kernel.SPEED],
            "voltage": means[kernel.PRESSURE],
            "current": means[kernel.FLOW],
        }
        return np.array([named[name] for name in self.names])

    def _grid(self, parts: int, steps: int, interval: float) -> Propagator:
        """Return the propagator of a grid, computed once for each."""
        key = (parts, steps)
        if key not in self._grids:
            self._grids[key] = propagator(self.plant, interval, steps)
        return self._grids[key]

    def _energies(self) -> tuple[float, float, float]:
        """Return the energies of box, bed and exciter, J; that of the bed includes the height of
        its rows in the box.
        """
        p, y, bed = self.plant, self._y, self.bed
        square = 0.5 * y[V] ** 2
        box = (p.box - bed.bonded) * square
        rows = 0.5 * bed.row_mass * float(self._w @ self._w) - bed.row_mass * bed.pull * float(
            self._u.sum()
        )
        exciter = 0.5 * (
            p.armature * y[VA] ** 2
            + p.body * y[VB] ** 2
            + p.flexure * (y[XA] - y[XB]) ** 2
            + p.stinger * (y[XA] - y[X]) ** 2
            + p.isolation * y[XB] ** 2
            + p.inductance * y[I] ** 2
        )
        return float(box), float(rows + bed.bonded * square), float(exciter)

    def _account(
        self, sums: Array, period: float, before: tuple[float, ...], after: tuple[float, ...]
    ) -> Array:
        """Return one row of COUPLED_COLUMNS from the kernel's sums over `period` (s)."""
        box, bed, exciter = (b - a for a, b in zip(before, after, strict=True))
        dashpot, noise, gas, cords = self._viscous * sums[kernel.SQUARE]
        spent = {
            "W_f": sums[kernel.FRICTION],
            "W_c": sums[kernel.COLLISION],
            "W_viscous": dashpot,
            "W_noise": noise,
            "W_air": sums[kernel.AIR],
            "W_gas": gas,
            "W_mount": cords + sums[kernel.GUIDE],
            "dKE_bed": bed,
            "dKE_box": box,
        }
        gauge, electric = sums[kernel.GAUGE], sums[kernel.ELECTRIC]
        lost = sums[[kernel.COPPER, kernel.FLEXURE, kernel.STINGER, kernel.ISOLATION]]
        tiny = float(np.finfo(float).tiny)
        inertial = (
            2.0
            * np.pi
            * (self.plant.box + self.bed.mass - self.bed.bonded)
            * sums[kernel.SQUARE]
            / period
        )
        scale = max(abs(gauge), inertial, tiny)
        return np.array([[
            *(spent[name] for name in SPENT), gauge, (gauge - sum(spent.values())) / scale,
            electric, *lost, sums[kernel.COIL], exciter,
            (electric - lost.sum() - exciter - gauge) / max(scale, abs(electric)),
        ]])  # fmt: skip

    def _used(self, sums: Array, clipped: float) -> Limits:
        """Return the utilisation of the limits from the kernel's largest values."""
        e = self._exciter
        force = max(sums[kernel.MOST_PULL], sums[kernel.MOST_PUSH])
        return Limits(
            voltage=float(sums[kernel.MOST_VOLTAGE] / e.voltage_peak),
            current=float(sums[kernel.MOST_CURRENT] / e.current_peak),
            stroke=float(sums[kernel.MOST_TRAVEL] / e.stroke),
            force=float(force / e.force_peak),
            buckling=float(sums[kernel.MOST_PUSH] / e.stinger_buckling),
            clipped=clipped,
        )
