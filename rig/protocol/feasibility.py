"""Checks over several fields: are scene, drive and acquisition compatible, and is the combination
implemented?
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cache
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from rig.catalog.entries_by_name import IDEAL, analyzer, names, sensors_for, transducer
from rig.errors import nearest, quote
from rig.protocol.deliberate_errors import DeliberateError
from rig.protocol.spec import (
    BEDS,
    BEDS_OF_ROWS,
    BUILT_BEDS,
    BUILT_MODES,
    HORIZONTAL_ONLY_BEDS,
    Acquire,
    Drive,
    Protocol,
    Scene,
)

if TYPE_CHECKING:
    from daq.chain.channel import AnalyzerSpec

LEAST_SAMPLES = 500  # per cycle, where acquire.paper_rule holds
MOST_SAMPLES_PER_CYCLE = 10**6
MOST_SAMPLES = 10**9
MOST_LAYERS = 20000
LEAST_SWEEP = 20
"""Smallest number of cycles of a sweep: each cycle is one point of the response curve."""
MOST_ROWS = 10**7
LONGEST_READING = 64
"""Largest number of cycles that the analysis reads at a time. W over a fraction of a cycle is read
from one such stretch.
"""


@dataclass(frozen=True)
class Conflict:
    """A mistake in several fields taken together. The message names the first of `paths`; the others
    take part in it.
    """

    paths: tuple[str, ...]
    found: str
    allowed: str
    hint: str = ""


def conflicts(scene: Scene, drive: Drive, acquire: Acquire) -> Iterator[Conflict]:
    """Yield every reason why this condition cannot be run."""
    yield from _not_built(scene, drive)
    yield from _names(scene, acquire)
    yield from _box(scene)
    yield from _sampling(drive, acquire)
    yield from _sweep(drive, acquire)
    yield from _inputs(drive, acquire)


def _not_built(scene: Scene, drive: Drive) -> Iterator[Conflict]:
    """Yield beds, drives and their combinations with axis and support that are not implemented."""
    if scene.bed not in BUILT_BEDS:
        yield Conflict(("scene.bed",), f"the bed {scene.bed}, not built yet", ", ".join(BUILT_BEDS))
    if drive.mode not in BUILT_MODES:
        yield Conflict(
            ("drive.mode",), f"the drive {drive.mode}, not built yet", ", ".join(BUILT_MODES)
        )
    if scene.axis != "horizontal" and scene.bed in HORIZONTAL_ONLY_BEDS:
        able = [bed for bed in BEDS if bed not in HORIZONTAL_ONLY_BEDS]
        waiting = [bed for bed in able if bed not in BUILT_BEDS]
        beds = ", ".join(able)
        if waiting:
            beds += f" ({', '.join(waiting)}: not built yet)"
        found = f"axis {scene.axis} with bed {scene.bed}"
        yield Conflict(
            ("scene.axis", "scene.bed"),
            found,
            f"horizontal for this bed; on this axis the beds {beds}",
        )
    if scene.bed == "single_mass":
        yield from _single_mass(scene)
    if scene.axis != "horizontal" and scene.support == "guide":
        found = f"axis {scene.axis} with support guide, which carries the weight across the drive"
        yield Conflict(("scene.support", "scene.axis"), found, "none or cords on this axis")


def _single_mass(scene: Scene) -> Iterator[Conflict]:
    """Yield mistakes in friction, initial position and gap of the bed `single_mass`."""
    single_mass = scene.single_mass
    if scene.axis != "horizontal" and single_mass.friction > 0.0:
        found = f"friction {single_mass.friction:g} on axis {scene.axis}, where the single mass lies on no floor along the drive"
        yield Conflict(("scene.single_mass.friction", "scene.axis"), found, "0 on this axis")
    if isinstance(single_mass.gap, float | int) and single_mass.start > single_mass.gap:
        found = f"a start {single_mass.start:g} m above the floor"
        yield Conflict(
            ("scene.single_mass.start", "scene.single_mass.gap"),
            found,
            f"at most the gap, {single_mass.gap:g} m",
        )
    along = "length" if scene.axis == "horizontal" else "height"
    room = getattr(scene.cavity, along)
    if isinstance(single_mass.gap, float | int) and single_mass.gap >= room:
        found = f"a gap of {single_mass.gap:g} m in a cavity of {along} {room:g} m"
        allowed = "less than the cavity along the axis, or none"
        yield Conflict(("scene.single_mass.gap", f"scene.cavity.{along}"), found, allowed)


def _names(scene: Scene, acquire: Acquire) -> Iterator[Conflict]:
    """Yield names that the catalog does not have."""
    sensors = acquire.sensors
    for path, name, known in (
        ("scene.grains.material", scene.grains.material, names("material")),
        ("scene.cavity.material", scene.cavity.material, names("material")),
        ("acquire.analyzer", acquire.analyzer, (*names("analyzer"), IDEAL)),
        ("acquire.sensors.force", sensors.force, (*sensors_for("force"), IDEAL)),
        (
            "acquire.sensors.acceleration",
            sensors.acceleration,
            (*sensors_for("acceleration"), IDEAL),
        ),
        ("acquire.sensors.current", sensors.current, (*sensors_for("current"), IDEAL)),
        ("acquire.sensors.voltage", sensors.voltage, (*sensors_for("voltage"), IDEAL)),
    ):
        if isinstance(name, str) and name not in known:
            yield Conflict((path,), quote(name), ", ".join(known), nearest(name, known))


def _box(scene: Scene) -> Iterator[Conflict]:
    """Yield grains that are too large for the cavity, and beds of too few or too many layers."""
    cavity, grains = scene.cavity, scene.grains
    smallest = min(cavity.length, cavity.width, cavity.height)
    cavity_paths = ("scene.cavity.length", "scene.cavity.width", "scene.cavity.height")
    if grains.diameter >= smallest:
        found = f"grains of {grains.diameter:g} m in a cavity of {smallest:g} m"
        yield Conflict(
            ("scene.grains.diameter", *cavity_paths), found, "grains smaller than the cavity"
        )
        return
    if scene.bed not in BEDS_OF_ROWS or grains.fill == 0.0:
        return
    layers = round(grains.fill * cavity.height / grains.diameter)
    paths = ("scene.grains.diameter", "scene.grains.fill", "scene.cavity.height")
    if layers < 1:
        found = f"a fill of {grains.fill * cavity.height:g} m, less than half a layer of {grains.diameter:g} m grains"
        yield Conflict(
            ("scene.grains.fill", *paths), found, "0, or at least half a layer of grains"
        )
    elif layers > MOST_LAYERS:
        yield Conflict(paths, f"{layers} layers of grains", f"at most {MOST_LAYERS} layers")
    elif scene.bed == "layers" and layers * scene.layers.rows > MOST_ROWS:
        found = f"{layers * scene.layers.rows} rows in all layers"
        yield Conflict(("scene.layers.rows", *paths), found, f"at most {MOST_ROWS}")


def _sampling(drive: Drive, acquire: Acquire) -> Iterator[Conflict]:
    """Yield sampling rates that the analyzer does not have, and runs of too many samples."""
    path, paths = (
        "acquire.samples_per_cycle",
        ("acquire.analyzer", "drive.frequency", "drive.sweep_to"),
    )
    wanted = acquire.samples_per_cycle
    if wanted < LEAST_SAMPLES and acquire.paper_rule:
        hint = "set acquire.paper_rule: false to go below"
        yield Conflict(
            (path, "acquire.paper_rule"),
            f"{wanted}",
            f"at least {LEAST_SAMPLES} samples per cycle",
            hint,
        )
    spec = _known_analyzer(acquire.analyzer)
    if spec is None:
        return
    fastest = max(spec.rates)
    # The tolerance is far above rounding: 51200 S/s is enough for 512 samples at 100 Hz.
    if fastest < drive.fastest * wanted * (1 - 1e-12):
        found = f"{wanted} samples per cycle at {drive.fastest:g} Hz"
        allowed = f"at most {fastest / drive.fastest:.4g} there: the fastest rate of {spec.model} is {fastest:g} S/s"
        yield Conflict((path, *paths), found, allowed)
        return
    actual = spec.rate_for(drive.fastest, wanted) / drive.frequency
    if actual > MOST_SAMPLES_PER_CYCLE:
        found = (
            f"{drive.frequency:g} Hz, {actual:.4g} samples per cycle at the analyzer's slowest rate"
        )
        yield Conflict(
            ("drive.frequency", *paths),
            found,
            f"at most {MOST_SAMPLES_PER_CYCLE} samples per cycle",
        )
    elif actual * (acquire.settle + acquire.record) > MOST_SAMPLES:
        found = f"{actual * (acquire.settle + acquire.record):.4g} samples in a run"
        yield Conflict(
            ("acquire.record", "acquire.settle", path, *paths), found, f"at most {MOST_SAMPLES}"
        )


def _sweep(drive: Drive, acquire: Acquire) -> Iterator[Conflict]:
    """Yield mistakes of a sweep, which needs an open-loop shaker and a cycle for each point."""
    if drive.sweep_to is None:
        return
    found = f"a sweep to {drive.sweep_to:g} Hz"
    if drive.mode != "shaker":
        yield Conflict(
            ("drive.sweep_to", "drive.mode"), f"{found} in {drive.mode} drive", "drive.mode: shaker"
        )
    elif drive.control != "open":
        allowed = "drive.control: open (no level is held through a resonance)"
        yield Conflict(("drive.sweep_to", "drive.control"), f"{found} under level control", allowed)
    if drive.sweep_to == drive.frequency:
        yield Conflict(
            ("drive.sweep_to", "drive.frequency"),
            f"{found} from the same",
            "another frequency, or null",
        )
    if acquire.trigger.channel != "none":
        allowed = "acquire.trigger.channel: none (the sweep starts after the settling)"
        yield Conflict(
            ("drive.sweep_to", "acquire.trigger.channel"), f"{found} started by a trigger", allowed
        )
    if acquire.record < LEAST_SWEEP:
        allowed = f"at least {LEAST_SWEEP} cycles"
        yield Conflict(
            ("acquire.record", "drive.sweep_to"), f"{found} in {acquire.record} cycles", allowed
        )


def _inputs(drive: Drive, acquire: Acquire) -> Iterator[Conflict]:
    """Yield mistakes in coupling and range of each channel, and in the trigger's channel."""
    spec = _known_analyzer(acquire.analyzer)
    for name in (item.name for item in fields(acquire.coupling)):
        sensor, coupling = getattr(acquire.sensors, name), getattr(acquire.coupling, name)
        path = f"acquire.coupling.{name}"
        if (
            coupling == "IEPE"
            and sensor in sensors_for(name)
            and transducer(sensor).clips_at is None
        ):
            found = f"IEPE for {sensor}, which has no amplifier to feed"
            yield Conflict((path, f"acquire.sensors.{name}"), found, "DC or AC")
        if coupling != "DC" and spec is not None and drive.frequency < spec.ac_corner:
            found = f"{coupling} with a drive at {drive.frequency:g} Hz"
            yield Conflict(
                (path, "drive.frequency"),
                found,
                f"DC below the coupling's corner, {spec.ac_corner:g} Hz",
            )
    if acquire.trigger.channel in ("current", "voltage") and not acquire.exciter_channels:
        allowed = (
            "none, force, acceleration; current and voltage with acquire.exciter_channels: true"
        )
        yield Conflict(
            ("acquire.trigger.channel", "acquire.exciter_channels"),
            acquire.trigger.channel,
            allowed,
        )
    for name in (item.name for item in fields(acquire.ranges)):
        volts = getattr(acquire.ranges, name)
        if volts == "auto" and drive.mode == "shaker":
            found = "auto in shaker-coupled drive, where no dry run is made"
            yield Conflict((f"acquire.ranges.{name}", "drive.mode"), found, "a range in V")
        if spec is not None and isinstance(volts, float) and volts not in spec.ranges:
            known = ", ".join(f"{value:g} V" for value in spec.ranges)
            path = f"acquire.ranges.{name}"
            yield Conflict(
                (path, "acquire.analyzer"), f"a range of {volts:g} V", f"{known}, or auto"
            )


@cache
def _known_analyzer(name: str) -> AnalyzerSpec | None:
    """Return an analyzer of the catalog, None for an unknown name (which `_names` reports)."""
    return analyzer(name) if name in (*names("analyzer"), IDEAL) else None


FOUND = ("scene.layers.rows", "acquire.settle", "acquire.record")
"""Fields that `fidelity: auto` chooses for each condition."""


def unfit(protocol: Protocol) -> Iterator[Conflict]:
    """Yield every field that is not compatible with the protocol's `fidelity`."""
    if protocol.fidelity != "auto":
        if protocol.tolerance is not None:
            found = f"{protocol.tolerance:g} with fidelity {protocol.fidelity}"
            yield Conflict(
                ("tolerance", "fidelity"),
                found,
                "a tolerance with fidelity: auto only",
                "add fidelity: auto",
            )
        return
    for axis in protocol.vary:
        for column, path in enumerate(axis.paths):
            if _varies_a_found_field(path, [row[column] for row in axis.rows]):
                found = f"{path} varied with fidelity auto, which finds {' and '.join(FOUND)}"
                yield Conflict(
                    (path, "fidelity"), found, "an axis over other fields, or fidelity: as_written"
                )
    modes = {protocol.drive.mode}
    modes |= {value for path, value in _varied(protocol) if path == "drive.mode"}
    modes |= {value.mode for path, value in _varied(protocol) if path == "drive"}
    for mode in sorted(modes - {"prescribed"}):
        found = f"the drive {mode} with fidelity auto, which looks at beds in a programmed motion"
        yield Conflict(("drive.mode", "fidelity"), found, "prescribed, or fidelity: as_written")
    if protocol.deliberate_error.cycles is not None:
        found = "a deliberate error in the cycles that are read, with fidelity auto, which finds acquire.record"
        yield Conflict(
            ("deliberate_error.cycles", "fidelity"),
            found,
            "another deliberate error, or fidelity: as_written",
        )


def _varies_a_found_field(path: str, values: Sequence[Any]) -> bool:
    """Return whether the values of an axis differ in a field that `fidelity: auto` chooses.

    An axis may hold a whole group (path `acquire`) whose values agree in these fields.
    """
    inside = [name[len(path) + 1 :] for name in FOUND if f"{name}.".startswith(f"{path}.")]
    if "" in inside:  # the axis is over the field itself
        return True
    return len({tuple(attrgetter(part)(value) for part in inside) for value in values}) > 1


def _varied(protocol: Protocol) -> Iterator[tuple[str, Any]]:
    """Yield every path of the grid's axes with each of its values."""
    for axis in protocol.vary:
        for row in axis.rows:
            yield from zip(axis.paths, row, strict=True)


def misfits(
    error: DeliberateError, scene: Scene, drive: Drive, acquire: Acquire
) -> Iterator[Conflict]:
    """Yield every reason why a deliberate error cannot be made in this condition."""
    if len(error.kinds) > 1:
        yield Conflict(
            ("deliberate_error",), " and ".join(error.kinds), "one deliberate error at most"
        )
    if error.kind is not None and drive.mode == "shaker":
        found = f"the deliberate error {error.kind} in shaker-coupled drive"
        yield Conflict(
            ("deliberate_error", "drive.mode"),
            found,
            "drive.mode: prescribed, where its rule holds",
        )
    sensor = acquire.sensors.acceleration
    known = sensor in sensors_for("acceleration")
    without_pole = sensor == IDEAL or (known and transducer(sensor).time_constant is None)
    if error.pole is not None and without_pole:
        found = f"a pole of {sensor}, which has none"
        yield Conflict(
            ("deliberate_error.pole", "acquire.sensors.acceleration"),
            found,
            "a sensor with a time constant",
        )
    if error.cycles is not None and not (
        math.ceil(error.cycles) <= acquire.record <= LONGEST_READING
    ):
        allowed = f"acquire.record from the next whole number of cycles to {LONGEST_READING} cycles"
        yield Conflict(
            ("deliberate_error.cycles", "acquire.record"),
            f"{error.cycles:g} of {acquire.record} cycles",
            allowed,
        )
    if error.corners is not None and acquire.exciter_channels:
        found = "force and acceleration AC coupled beside the exciter's channels"
        yield Conflict(
            ("deliberate_error.corners", "acquire.exciter_channels"),
            found,
            "acquire.exciter_channels: false",
        )
    if error.friction and not ("mount" in scene.losses and scene.support == "guide"):
        found = f"losses {', '.join(scene.losses) or 'none'} on support {scene.support}"
        paths = ("deliberate_error.friction", "scene.losses", "scene.support")
        yield Conflict(paths, found, "the loss mount on the support guide")
