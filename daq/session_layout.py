"""The session file's layout: every group and dataset, created before the first sample.

HDF5's low-level calls are used because a session has thousands of small objects and the high-level ones take some
five times longer. All space is allocated at creation, so that no metadata change while samples arrive: a killed
writer can only leave unwritten samples, which the status table does not count.
"""

import dataclasses
import json
from collections.abc import Mapping, Sequence
from typing import Any

import h5py
import numpy as np
from h5py import h5a, h5d, h5g, h5p, h5s, h5t

from daq.channel import ChannelInfo
from daq.session_plan import CHUNK, RunPlan, SessionError, SessionPlan, block_dtype, status_dtype

__all__ = ["build_session"]

AttributeValue = str | int | float | Sequence[str]
SCALAR = h5s.create(h5s.SCALAR)


def build_session(file: h5py.File, plan: SessionPlan) -> None:
    """Create everything of `plan` in an empty file. Raises SessionError for a plan that cannot be stored."""
    _check(plan)
    root = file.id
    file.attrs["synthetic"] = plan.synthetic
    _attributes(root, {"NX_class": "NXroot", "default": plan.runs[0].name, "schema": plan.schema, **plan.attrs})
    session = h5g.create(root, b"session")
    _attributes(session, {"NX_class": "NXentry", "rate": float(plan.rate)})
    runs = [_resolved(run, plan) for run in plan.runs]
    documents = {
        **plan.documents,
        "protocol": plan.protocol,
        "conditions": list(plan.conditions),
        "runs": [dataclasses.asdict(run) for run in runs],
        "scalars": list(plan.scalars),
    }
    for name, value in documents.items():
        _text(session, name, _json(name, value))
    _text(session, "protocol_text", plan.protocol_text)
    _array(session, "status", status_dtype, (len(runs),), written=True)
    table = h5g.create(session, b"channels")
    for position, channel in enumerate(plan.channels):
        _channel(table, channel, position)
    if plan.synthetic:
        truth = h5g.create(session, b"truth")
        for name, value in plan.truth_documents.items():
            _text(truth, name, _json(name, value))
    for run in runs:
        _run(root, run, plan)


def _check(plan: SessionPlan) -> None:
    reserved = {"protocol", "conditions", "runs", "scalars", "protocol_text", "status", "channels", "truth"}
    clash = reserved & set(plan.documents)
    if clash:
        raise SessionError(f"a session document cannot be called {sorted(clash)[0]!r}: the format uses that name")
    names = [run.name for run in plan.runs]
    if not names or not plan.channels:
        raise SessionError("a session needs at least one run and one channel")
    if len(set(names)) < len(names) or "session" in names or any("/" in name for name in names):
        raise SessionError("run names must be different, without '/', and not 'session'")
    if any(run.samples < 1 or run.blocks < 1 for run in plan.runs):
        raise SessionError("every run needs room for at least one sample and one block")
    unknown = {run.condition for run in plan.runs} - {str(condition["id"]) for condition in plan.conditions}
    if unknown:
        raise SessionError(f"a run names the condition {sorted(unknown)[0]!r}, which the plan does not list")


def _resolved(run: RunPlan, plan: SessionPlan) -> RunPlan:
    cycles = plan.ledger_cycles if run.ledger_cycles is None else run.ledger_cycles
    return dataclasses.replace(run, rate=float(run.rate or plan.rate), ledger_cycles=cycles)


def _run(root: Any, run: RunPlan, plan: SessionPlan) -> None:
    group = h5g.create(root, run.name.encode())
    _attributes(group, {
        "NX_class": "NXentry", "default": "data", "title": run.title or f"{run.condition}, repeat {run.repeat}",
        "condition": run.condition, "repeat": run.repeat, "order": run.order, "rate": float(run.rate or plan.rate),
        "t0": run.t0, "settle_samples": run.settle_samples,
    })  # fmt: skip
    names = [channel.name for channel in plan.channels]
    data = h5g.create(group, b"data")
    _attributes(data, {"NX_class": "NXdata", "signal": names[0], "axes": "."})
    if names[1:]:
        _attributes(data, {"auxiliary_signals": names[1:]})
    for channel in plan.channels:
        codes = _array(data, channel.name, np.dtype("<i4"), (run.samples,), chunk=min(CHUNK, run.samples))
        _attributes(codes, {
            "units": channel.unit, "scale": channel.scale, "offset": channel.offset, "sensitivity": channel.sensitivity,
            "long_name": f"{channel.quantity}: (code * scale + offset) / sensitivity",
        })  # fmt: skip
    _array(group, "blocks", block_dtype(len(names)), (run.blocks,), written=True)
    if plan.scalars:
        scalars = _array(group, "scalars", np.dtype("<f8"), (len(plan.scalars),), written=True)
        _attributes(scalars, {"names": plan.scalars})
    if plan.synthetic and plan.ledger_columns:
        truth = h5g.create(group, b"truth")
        ledger = _array(truth, "ledger", np.dtype("<f8"), (run.ledger_cycles or 0, len(plan.ledger_columns)))
        _attributes(ledger, {"columns": plan.ledger_columns, "units": "J"})


def _channel(table: Any, channel: ChannelInfo, position: int) -> None:
    """One group of attributes per channel; a missing time constant is an infinite one, corner 0 Hz."""
    values = dataclasses.asdict(channel)
    values["time_constant"] = float("inf") if channel.time_constant is None else channel.time_constant
    group = h5g.create(table, channel.name.encode())
    _attributes(group, {"NX_class": "NXsensor", "position": position, **values, "pole_Hz": channel.pole_Hz})


def _attributes(owner: Any, values: Mapping[str, AttributeValue]) -> None:
    for name, value in values.items():
        if isinstance(value, int):
            attribute, array = h5a.create(owner, name.encode(), h5t.STD_I64LE, SCALAR), np.array(value, "<i8")
            attribute.write(array)
        elif isinstance(value, float):
            attribute, array = h5a.create(owner, name.encode(), h5t.IEEE_F64LE, SCALAR), np.array(value, "<f8")
            attribute.write(array)
        else:
            texts = [value] if isinstance(value, str) else list(value)
            array = np.array([text.encode() for text in texts])
            kind = _text_type(array.dtype.itemsize)
            space = SCALAR if isinstance(value, str) else h5s.create_simple((len(texts),))
            h5a.create(owner, name.encode(), kind, space).write(array, mtype=kind)


def _text_type(size: int) -> Any:
    kind = h5t.C_S1.copy()
    kind.set_size(max(1, size))
    kind.set_cset(h5t.CSET_UTF8)
    kind.set_strpad(h5t.STR_NULLPAD)
    return kind


def _text(group: Any, name: str, text: str) -> None:
    """A scalar fixed-length UTF-8 dataset (attributes end at 64 kB, and variable lengths do not suit SWMR)."""
    array = np.array(text.encode())
    kind = _text_type(array.dtype.itemsize)
    h5d.create(group, name.encode(), kind, SCALAR).write(h5s.ALL, h5s.ALL, array, mtype=kind)


def _json(name: str, value: Any) -> str:
    try:
        return json.dumps(value, ensure_ascii=False, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise SessionError(f"the session document {name!r} cannot be written as JSON: {error}") from error


def _array(
    group: Any, name: str, dtype: np.dtype[Any], shape: tuple[int, ...], chunk: int = 0, written: bool = False
) -> Any:
    """A fixed-size dataset with its space allocated now; zeros are written out only where asked."""
    layout = h5p.create(h5p.DATASET_CREATE)
    layout.set_alloc_time(h5d.ALLOC_TIME_EARLY)
    layout.set_fill_time(h5d.FILL_TIME_ALLOC if written else h5d.FILL_TIME_NEVER)
    if chunk:
        layout.set_chunk((chunk,))
    kind = h5t.py_create(dtype)
    return h5d.create(group, name.encode(), kind, h5s.create_simple(shape), layout)
