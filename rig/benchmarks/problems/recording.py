"""The session's recorder beside plain h5py: the same file written by both, and the codes alone."""

import json
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from daq.chain.block import Block
from daq.session.layout import (
    channel_attributes,
    data_attributes,
    run_attributes,
    signal_attributes,
)
from daq.session.plan import CHUNK, RunPlan, SessionPlan, block_dtype, status_dtype
from daq.session.writer import Recorder
from rig.benchmarks.fill_protocol import fill_campaign
from rig.benchmarks.timing import against, interleaved, peak_memory, spread
from rig.campaign.session_plan import session_plan
from rig.prediction.forecast import forecast

Row = dict[str, Any]
Codes = np.typing.NDArray[np.int32]

BLOCKS = (5158, 16384, 4098)
"""Samples of the blocks in a run of 50 cycles, the shipped protocols' length, as a campaign reads
them.
"""

LONG = 50
"""Blocks of 16384 samples in a long run: 80 s."""

OURS, PLAIN, CODES = "recorder (ours)", "plain h5py: the same file", "plain h5py: codes alone"


def recorder(rounds: int) -> list[Row]:
    """Measure forty short runs, and two long ones."""
    campaign = fill_campaign("repeats=1")
    plan = session_plan(
        campaign, {c.id: forecast(c, campaign.rig, True) for c in campaign.conditions}
    )
    rows = compared(f"recorder, {len(plan.runs)} short runs", plan, BLOCKS, rounds)
    return [*rows, *compared("recorder, 2 long runs", of_runs(plan, 2), (CHUNK,) * LONG, rounds)]


def of_runs(plan: SessionPlan, count: int) -> SessionPlan:
    """Return the plan of the first `count` runs alone."""
    return replace(plan, runs=plan.runs[:count])


def compared(problem: str, plan: SessionPlan, blocks: tuple[int, ...], rounds: int) -> list[Row]:
    """Write every run of a plan in these blocks: codes, block and status rows, ledger and scalars,
    each flushed.
    """
    runs = tuple(replace(run, samples=sum(blocks), blocks=len(blocks)) for run in plan.runs)
    plan = replace(plan, runs=runs)
    rng = np.random.Generator(np.random.SFC64(1))
    codes = rng.integers(-(2**23), 2**23, (len(plan.channels), sum(blocks)), dtype=np.int32)
    with tempfile.TemporaryDirectory() as folder:
        session, plain, bare = (
            Path(folder) / name for name in ("session.h5", "plain.h5", "bare.h5")
        )
        calls: dict[str, Callable[[], None]] = {
            OURS: partial(_anew, _ours, session, plan, blocks, codes),
            PLAIN: partial(_anew, _plain, plain, plan, blocks, codes),
            CODES: partial(_anew, _codes_alone, bare, plan, blocks, codes),
        }
        found: dict[str, Row] = {}
        for name, call in calls.items():
            call()
            _, kilobytes = peak_memory(call)
            found[name] = {
                "kind": "part",
                "problem": problem,
                "method": name,
                "failure": None,
                "memory_kB": kilobytes,
                "what": f"{len(runs)} runs of {sum(blocks)} samples in {len(blocks)} blocks, {len(codes)} channels; "
                "values and attributes that come back different",
            }
        found[OURS]["error"] = found[PLAIN]["error"] = float(len(different(session, plain)))
        with h5py.File(bare, "r") as file:
            names = [f"{run.name}/data/{channel.name}" for run in runs for channel in plan.channels]
            found[CODES]["error"] = float(
                sum(
                    not np.array_equal(file[n][:], codes[k % len(codes)])
                    for k, n in enumerate(names)
                )
            )
        times = interleaved(calls, rounds)
        for name, seconds in times.items():
            found[name]["ms"] = spread([1e3 * value for value in seconds])
        found[OURS]["speed"] = against(times, OURS, PLAIN, 0.7)
    return list(found.values())


def _pieces(plan: SessionPlan) -> tuple[np.ndarray[Any, Any], dict[str, float]]:
    """Return a run's ledger and scalars."""
    cycles = max(run.ledger_cycles or plan.ledger_cycles for run in plan.runs)
    return np.ones((cycles, len(plan.ledger_columns))), dict.fromkeys(plan.scalars, 1.0)


def _anew(write: Callable[..., None], path: Path, *arguments: Any) -> None:
    """Write to a new path after renaming the last file, because replacing a file costs time that is
    not recording.
    """
    if path.exists():
        path.rename(path.with_name(f"{path.stem}-{time.monotonic_ns()}"))
    write(path, *arguments)


def _ours(path: Path, plan: SessionPlan, blocks: tuple[int, ...], codes: Codes) -> None:
    ledger, scalars = _pieces(plan)
    flags, clipped = np.zeros(len(codes), np.uint16), np.zeros(len(codes), np.uint32)
    with Recorder.create(path, plan) as writer:
        for run in plan.runs:
            first = 0
            for count in blocks:
                writer.append(
                    run.name, Block(first, codes[:, first : first + count], flags, clipped, False)
                )
                first += count
            writer.write_ledger(run.name, 0, ledger)
            writer.finish(run.name, scalars)


def _plain(path: Path, plan: SessionPlan, blocks: tuple[int, ...], codes: Codes) -> None:
    """Write the session's layout (docs/session-format.md) by h5py's own calls, in single-writer
    mode.
    """
    ledger, scalars = _pieces(plan)
    nothing = (np.zeros(len(codes), np.uint16), np.zeros(len(codes), np.uint32))
    with h5py.File(path, "w", libver=("v110", "v110")) as file:
        _session(file, plan)
        for run in plan.runs:
            _run(file, run, plan)
        file.swmr_mode = True
        status = file["session/status"]
        for number, run in enumerate(plan.runs):
            entry, first = file[run.name], 0
            channels, table = (
                [entry["data"][channel.name] for channel in plan.channels],
                entry["blocks"],
            )
            for used, count in enumerate(blocks):
                for row, data in enumerate(channels):
                    data[first : first + count] = codes[row, first : first + count]
                    data.flush()
                table[used] = np.array((first, count, *nothing), table.dtype)
                table.flush()
                first += count
                status[number] = np.array((first, used + 1, 0, 0), status_dtype)
                status.flush()
            for name, values in (
                ("truth/ledger", ledger),
                ("scalars", np.array(list(scalars.values()))),
            ):
                entry[name][...] = values
                entry[name].flush()
            status[number] = np.array((first, len(blocks), 1, 0), status_dtype)
            status.flush()


def _session(file: Any, plan: SessionPlan) -> None:
    """Write the root and `session`."""
    _attributes(
        file,
        {"NX_class": "NXroot", "default": plan.runs[0].name, "schema": plan.schema, **plan.attrs},
    )
    file.attrs["synthetic"] = plan.synthetic
    session = _group(file, "session", {"NX_class": "NXentry", "rate": float(plan.rate)})
    runs = [
        replace(run, rate=float(run.rate or plan.rate), ledger_cycles=run.ledger_cycles)
        for run in plan.runs
    ]
    documents = {**plan.documents, "protocol": plan.protocol, "conditions": list(plan.conditions),
                 "runs": [asdict(run) for run in runs], "scalars": list(plan.scalars)}  # fmt: skip
    for name, value in documents.items():
        session[name] = _text(json.dumps(value, ensure_ascii=False))
    session["protocol_text"] = _text(plan.protocol_text)
    session.create_dataset("status", len(runs), status_dtype)
    table = _group(session, "channels", {"NX_class": "NXcollection"})
    for position, channel in enumerate(plan.channels):
        _group(table, channel.name, channel_attributes(channel, position))
    truth = _group(session, "truth", {"NX_class": "NXcollection"})
    for name, value in plan.truth_documents.items():
        truth[name] = _text(json.dumps(value, ensure_ascii=False))


def _run(file: Any, run: RunPlan, plan: SessionPlan) -> None:
    entry = _group(file, run.name, run_attributes(replace(run, rate=float(run.rate or plan.rate))))
    data = _group(entry, "data", data_attributes(plan.channels))
    for channel in plan.channels:
        signal = data.create_dataset(
            channel.name, run.samples, "<i4", chunks=(min(CHUNK, run.samples),)
        )
        _attributes(signal, signal_attributes(channel))
    entry.create_dataset("blocks", run.blocks, block_dtype(len(plan.channels)))
    _attributes(entry.create_dataset("scalars", len(plan.scalars), "<f8"), {"names": plan.scalars})
    truth = _group(entry, "truth", {"NX_class": "NXcollection"})
    ledger = truth.create_dataset(
        "ledger", (run.ledger_cycles or plan.ledger_cycles, len(plan.ledger_columns)), "<f8"
    )
    _attributes(ledger, {"columns": plan.ledger_columns, "units": "J"})


def _group(owner: Any, name: str, values: Any) -> Any:
    made = owner.create_group(name)
    _attributes(made, values)
    return made


def _attributes(owner: Any, values: Any) -> None:
    """Write attributes as the session has them: text of fixed length."""
    for name, value in values.items():
        if isinstance(value, str):
            owner.attrs[name] = _text(value)
        elif isinstance(value, int | float):
            owner.attrs[name] = value
        else:
            owner.attrs[name] = np.array([entry.encode() for entry in value])


def _text(value: str) -> np.bytes_:
    return np.bytes_(value.encode())


def _codes_alone(path: Path, plan: SessionPlan, blocks: tuple[int, ...], codes: Codes) -> None:
    """Write codes without attributes, tables or single-writer mode, as a first script would."""
    with h5py.File(path, "w", libver=("v110", "v110")) as file:
        for run in plan.runs:
            for channel in plan.channels:
                file.create_dataset(
                    f"{run.name}/data/{channel.name}",
                    run.samples,
                    "<i4",
                    chunks=(min(CHUNK, run.samples),),
                )
        for run in plan.runs:
            first = 0
            channels = [file[run.name]["data"][channel.name] for channel in plan.channels]
            for count in blocks:
                for row, data in enumerate(channels):
                    data[first : first + count] = codes[row, first : first + count]
                    data.flush()
                first += count


def different(one: Path, other: Path) -> list[str]:
    """Return the names of the objects and attributes in which two files differ."""
    found = []
    with h5py.File(one, "r") as a, h5py.File(other, "r") as b:
        names: list[tuple[list[str], Any]] = []
        for file in (a, b):
            names.append(([""], file))
            file.visit(names[-1][0].append)
        found += sorted(set(names[0][0]) ^ set(names[1][0]))
        for name in sorted(set(names[0][0]) & set(names[1][0])):
            x, y = a[name or "/"], b[name or "/"]
            if isinstance(x, h5py.Dataset) and (
                x.dtype.itemsize != y.dtype.itemsize
                or x.chunks != y.chunks
                or np.asarray(x[()]).tobytes() != np.asarray(y[()]).tobytes()
            ):
                found.append(name)
            keys = set(x.attrs) ^ set(y.attrs)
            keys |= {
                key
                for key in set(x.attrs) & set(y.attrs)
                if _plain_value(x.attrs[key]) != _plain_value(y.attrs[key])
            }
            found += [f"{name}@{key}" for key in sorted(keys)]
    return found


def _plain_value(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return [_plain_value(entry) for entry in value.tolist()]
    return value.decode() if isinstance(value, bytes) else value
