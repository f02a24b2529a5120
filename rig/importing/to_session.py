"""Write a session from a laboratory's own records. Energies, uncertainties and report are then
computed as for a session of the rig.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.session.record import AnalysisError
from analysis.session.run_flags import DOUBT
from analysis.signals.examination import clipped
from analysis.signals.stationary import fundamental, noise_rms
from daq.chain.block import Block, Flag
from daq.chain.channel import ChannelInfo
from daq.formats.sidecar import Sidecar
from daq.session.plan import RunPlan, SessionPlan
from daq.session.writer import Recorder
from daq.strange_text import visible
from rig.campaign.provenance import now, provenance
from rig.catalog.rig_file import load_rig
from rig.errors import InputError, Mistake
from rig.importing.exported_record import certificate_of, channel_in, with_certificate
from rig.importing.lab_record import Reading, read_record
from rig.importing.mapping import (
    ASSUMED_U,
    AccelerationColumn,
    ForceColumn,
    Known,
    LoadedMap,
    RecordMap,
    RunFile,
)
from rig.prediction.document import condition_facts, prediction_document, predictions
from rig.prediction.parameter_uncertainty import model_ratios
from rig.protocol.grid import conditions
from rig.protocol.spec import Drive, Protocol

Array = NDArray[np.float64]

BLOCK = 16384  # samples
FULL_SCALE = 2**30  # code of the largest value; the resolution is 9e-10 of it
SAME_RATE = 1e-6  # relative, between the channels of a record and between records
SAME_PHASE = 0.02  # cycles by which the runs of one condition may drift apart over a record
ALL_FLAGS = sum(Flag)


def import_records(
    files: Sequence[Path], loaded: LoadedMap, path: Path, overwrite: bool = False
) -> None:
    """Write the session `path` from records as a mapping says.

    files : one run each, all of the mapping's condition; or, if the mapping lists `runs`, the
        folder of their files

    Raises InputError if mapping and records are incompatible, AnalysisError if a record is not
    steady, FormatError if a file cannot be read, SessionError if the session cannot be written.
    Nothing is written unless every record is usable.
    """
    wanted = _wanted(files, loaded)
    readings = [read_record(file, run, loaded.mapping) for file, run in wanted]
    rates = {reading.rate for reading in readings}
    if max(rates) > min(rates) * (1 + SAME_RATE):
        raise InputError(
            Mistake(
                str(loaded.path),
                "rate",
                f"records at {min(rates):g} and {max(rates):g} Hz",
                "one rate in a session",
            )
        )
    groups: dict[str, list[Reading]] = {}
    for reading in readings:
        groups.setdefault(reading.known.id, []).append(reading)
    plan = _plan(loaded, groups)
    path.parent.mkdir(parents=True, exist_ok=True)
    with Recorder.create(path, plan, overwrite) as recorder:
        ordered = [reading for group in groups.values() for reading in group]
        for run, reading in zip(plan.runs, ordered, strict=True):
            _record(recorder, run.name, reading, loaded.mapping, plan)


def _wanted(files: Sequence[Path], loaded: LoadedMap) -> list[tuple[Path, RunFile]]:
    """Return the path of each record with its entry in the mapping."""
    mapping = loaded.mapping
    if not mapping.runs:
        return [(file, RunFile(file.name, mapping.condition)) for file in files]
    if len(files) != 1 or not files[0].is_dir():
        raise InputError(
            Mistake(
                "FILE", "", "files beside a mapping with runs", "the folder that holds its files"
            )
        )
    return [(files[0] / run.file, run) for run in mapping.runs]


def _plan(loaded: LoadedMap, groups: dict[str, list[Reading]]) -> SessionPlan:
    """Return the plan of the session; `groups` holds the records of each condition."""
    mapping = loaded.mapping
    facts, predicted = [], {}
    for name, group in groups.items():
        known, frequency = group[0].known, math.fsum(r.frequency for r in group) / len(group)
        drift = max(abs(r.frequency - frequency) * r.cycles / frequency for r in group)
        if drift > SAME_PHASE:
            raise AnalysisError(
                f"condition {name}: its records drift apart by {drift:.2g} cycles; they need ids of their own"
            )
        own, found = _condition(mapping, known, group, frequency)
        facts.append(own)
        predicted.update(found)
    readings = [reading for group in groups.values() for reading in group]
    created = now()
    return SessionPlan(
        rate=readings[0].rate,
        channels=tuple(_channel(name, column, readings) for name, column in _columns(mapping)),
        runs=tuple(_runs(groups, created)),
        conditions=tuple(facts),
        protocol_text=loaded.text,
        protocol={"name": mapping.name, "question": mapping.question},
        documents={
            **({"prediction": {"conditions": predicted}} if mapping.scene is not None else {}),
            "rig": {"name": "laboratory", "values": _assumed(mapping, readings)},
            "provenance": provenance(
                loaded.text, 0, math.fsum(r.force.size / r.rate for r in readings)
            ),
            "import": [
                {
                    "file": visible(r.source.name),
                    "sha256": r.digest,
                    "frequency": r.frequency,
                    "taken_from_the_file": [visible(told) for told in r.told],
                    **asdict(r.steady),
                }
                for r in readings
            ],
        },
        synthetic=False,
        scalars=_doubts(readings),
    )


def _doubts(readings: Sequence[Reading]) -> tuple[str, ...]:
    """Return the names of the scalars that hold what was found wrong in any of the records."""
    return tuple(sorted({f"{DOUBT}{name}" for reading in readings for name in reading.doubts}))


def _runs(groups: dict[str, list[Reading]], created: str) -> list[RunPlan]:
    """Return the plan of each run, the records of a condition in the order given."""
    plans: list[RunPlan] = []
    for name, group in groups.items():
        for repeat, reading in enumerate(group, start=1):
            size = reading.force.size
            plans.append(
                RunPlan(
                    name=f"run_{len(plans) + 1:04d}",
                    condition=name,
                    repeat=repeat,
                    order=len(plans) + 1,
                    samples=size,
                    settle_samples=reading.start,
                    blocks=-(-size // BLOCK),
                    t0=created,
                    title=visible(reading.source.name),
                )
            )
    return plans


def _condition(
    mapping: RecordMap, known: Known, group: Sequence[Reading], frequency: float
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the facts of a condition and, if the mapping has a scene, its prediction at the level
    reached.
    """
    reached = math.fsum(_level(r) for r in group) / len(group)
    level = known.acceleration or reached
    settle = group[0].start * frequency / group[0].rate
    times = {
        "settle_cycles": settle,
        "record_cycles": min(r.cycles for r in group),
        "frequency": frequency,
    }
    if mapping.scene is None:
        facts = {name: value for name, value in asdict(known).items() if name != "acceleration"}
        return {
            **facts,
            "drive": "measured",
            "carried": False,
            "acceleration_set": level,
            **times,
        }, {}
    rig = load_rig(mapping.rig)
    protocol = Protocol(
        name=mapping.name,
        scene=mapping.scene,
        drive=Drive(frequency=frequency, acceleration=reached),
    )
    condition = replace(conditions(protocol)[0], id=known.id)
    found = predictions([condition], rig, 1)
    facts = condition_facts(condition, rig, found[known.id][0], group[0].rate)
    predicted = prediction_document(found)["conditions"]
    # The history of the bed before the record is not known.
    predicted[known.id]["u_settling"] = 0.0
    ratios = model_ratios(condition, rig)
    if ratios is not None:
        predicted[known.id]["model"] = list(ratios)
    return {
        **facts,
        **times,
        "drive": "measured",
        "losses": [],
        "acceleration_set": level,
    }, predicted


def _level(reading: Reading) -> float:
    """Return the amplitude of the acceleration's fundamental over the whole cycles of a record,
    m/s^2.
    """
    stop = reading.start + round(reading.cycles * reading.rate / reading.frequency)
    return abs(
        fundamental(reading.acceleration[reading.start : stop], 0, reading.rate, reading.frequency)
    )


def _columns(mapping: RecordMap) -> tuple[tuple[str, ForceColumn | AccelerationColumn], ...]:
    """Return the columns of the mapping by channel name, in the order of the channel table."""
    return (("force", mapping.force), ("acceleration", mapping.acceleration))


def _channel(
    name: str, column: ForceColumn | AccelerationColumn, readings: Sequence[Reading]
) -> ChannelInfo:
    """Return the row of the channel table; a code is 2^-30 of the largest value, so that no
    resolution of the record is lost.

    Noise that the mapping does not state is estimated from the differences between cycles in the
    quietest record. The impacts of the bed differ from cycle to cycle as well, but contribute least
    there.
    """
    largest = max(float(np.abs(getattr(reading, name)).max()) for reading in readings) or 1.0
    noise = column.noise
    if noise is None:
        every = (noise_rms(getattr(r, name)[r.start :], r.rate / r.frequency) for r in readings)
        noise = min(filter(None, every), default=0.0)
    sensitivity = column.sensitivity or 1.0
    channel = ChannelInfo(
        name=name,
        quantity=name,
        unit="N" if name == "force" else "m/s^2",
        model=column.model,
        serial=column.serial,
        direction=column.direction,
        coupling="not stated",
        range_V=(column.range or largest) * sensitivity,
        scale=largest * sensitivity / FULL_SCALE,
        offset=0.0,
        sensitivity=sensitivity,
        time_constant=None if isinstance(column.time_constant, str) else column.time_constant,
        time_constant_spread=column.time_constant_spread,
        filter_delay=0.0,
        skew=-column.delay,
        calibration_date=column.calibration_date,
        calibration_U=ASSUMED_U if column.calibration_U is None else column.calibration_U,
        gain_tolerance=column.gain_tolerance,
        clock_ppm=0.0,
        noise_rms=noise,
        skew_tolerance=column.delay_tolerance,
    )
    certificate = _certificate(column, readings)
    if certificate is None:
        return channel
    corrected = readings[0].sidecar is not None and readings[0].sidecar.corrected
    return with_certificate(channel, column, certificate, corrected, readings[0].frequency)


def _certificate(
    column: ForceColumn | AccelerationColumn, readings: Sequence[Reading]
) -> Mapping[str, Any] | None:
    """Return the certificate of a channel from the files beside the records, None for none. Raises
    InputError if these files disagree.
    """
    first, *others = readings
    certificate = certificate_of(first.sidecar, column)
    for other in others:
        kinds = [one.sidecar and one.sidecar.corrected for one in (first, other)]
        if kinds[0] != kinds[1] or certificate_of(other.sidecar, column) != certificate:
            found = f"{first.source.name} and {other.source.name}, whose files of rig export say different things"
            raise InputError(
                Mistake("FILE", "", found, "records of one session, all corrected or all raw")
            )
    return certificate


def _assumed(mapping: RecordMap, readings: Sequence[Reading]) -> list[dict[str, Any]]:
    """Return the values that the uncertainty needs and the mapping does not state, as assumed."""
    return [
        {"path": f"{name}.calibration_U", "value": ASSUMED_U, "unit": "", "status": "assumed",
         "source": "a usual certificate's, k = 2: the mapping states none"}
        for name, column in _columns(mapping)
        if column.calibration_U is None and _certificate(column, readings) is None
    ]  # fmt: skip


def _record(
    recorder: Recorder,
    run: str,
    reading: Reading,
    mapping: RecordMap,
    plan: SessionPlan,
) -> None:
    """Write the blocks of a run, with the quality bits of clipped samples and of the sidecar."""
    values = [reading.force, reading.acceleration]
    codes = np.stack([
        np.rint(v * (channel.sensitivity / channel.scale)).astype(np.int32)
        for v, channel in zip(values, plan.channels, strict=True)
    ])  # fmt: skip
    at_rail = np.stack(
        [
            clipped(v, column.range, reading.rate / reading.frequency)
            for v, (_, column) in zip(values, _columns(mapping), strict=True)
        ]
    )
    for start in range(0, codes.shape[1], BLOCK):
        part = slice(start, start + BLOCK)
        high, low = (at_rail[:, part] & (codes[:, part] * sign > 0) for sign in (1, -1))
        flags = (Flag.OVERLOAD_HI * high.any(axis=1) + Flag.OVERLOAD_LO * low.any(axis=1)).astype(
            np.uint16
        )
        count = at_rail[:, part].sum(axis=1).astype(np.uint32)
        flags |= _stated_flags(reading.sidecar, mapping, start, start + codes[:, part].shape[1])
        recorder.append(run, Block(start, codes[:, part], np.asarray(flags), count, False))
    recorder.finish(
        run,
        {name: float(name.removeprefix(DOUBT) in reading.doubts) for name in plan.scalars},
    )


def _stated_flags(
    sidecar: Sidecar | None, mapping: RecordMap, start: int, stop: int
) -> NDArray[np.uint16]:
    """Return the quality bits that the file beside a record states for samples start..stop, shape
    (channels,).
    """
    found = np.zeros(len(_columns(mapping)), np.uint16)
    if sidecar is None:
        return found
    for number, (_, column) in enumerate(_columns(mapping)):
        name = channel_in(sidecar, column)
        for block in sidecar.flags:
            overlaps = block.start < stop and start < block.start + block.count
            if overlaps and name is not None and name in block.flags:
                found[number] |= np.uint16(block.flags[name] & ALL_FLAGS)
    return found
