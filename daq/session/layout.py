"""The session file's layout: creates every group and dataset before the first sample
(docs/session-format.md).
"""

import dataclasses
import json
from collections.abc import Sequence
from typing import Any

from daq.chain.channel import ChannelInfo
from daq.session.hdf5 import AttributeValue, array, attributes, group, text
from daq.session.plan import (
    CHUNK,
    RUN_NAME,
    RunPlan,
    SessionError,
    SessionPlan,
    block_dtype,
    status_dtype,
)

__all__ = [
    "OWN_NAMES",
    "ROOT_NAMES",
    "build_session",
    "channel_attributes",
    "data_attributes",
    "run_attributes",
    "signal_attributes",
]

OWN_NAMES = frozenset(
    {"protocol", "conditions", "runs", "scalars", "protocol_text", "status", "channels", "truth"}
)
ROOT_NAMES = frozenset({"NX_class", "default", "schema", "synthetic"})


def build_session(file: Any, plan: SessionPlan) -> None:
    """Create everything in `plan` in an empty file.

    Raises SessionError for a plan that cannot be stored.
    """
    _check(plan)
    root = file.id
    # As a boolean: the low-level `attributes` would write an integer.
    file.attrs["synthetic"] = plan.synthetic
    attributes(
        root,
        {"NX_class": "NXroot", "default": plan.runs[0].name, "schema": plan.schema, **plan.attrs},
    )
    session = group(root, "session", {"NX_class": "NXentry", "rate": float(plan.rate)})
    runs = [_resolved(run, plan) for run in plan.runs]
    # The format's own documents last: `_check` refuses plans that would replace them.
    documents = {
        **plan.documents,
        "protocol": plan.protocol,
        "conditions": list(plan.conditions),
        "runs": [dataclasses.asdict(run) for run in runs],
        "scalars": list(plan.scalars),
    }
    for name, value in documents.items():
        text(session, name, _json(name, value))
    text(session, "protocol_text", plan.protocol_text)
    array(session, "status", status_dtype, (len(runs),))
    table = group(session, "channels", {"NX_class": "NXcollection"})
    for position, channel in enumerate(plan.channels):
        group(table, channel.name, channel_attributes(channel, position))
    if plan.synthetic:
        truth = group(session, "truth", {"NX_class": "NXcollection"})
        for name, value in plan.truth_documents.items():
            text(truth, name, _json(name, value))
    for run in runs:
        _run(root, run, plan)


def _check(plan: SessionPlan) -> None:
    """Raise SessionError for a plan that the format cannot hold."""
    clash = sorted(OWN_NAMES & set(plan.documents))
    if clash:
        raise SessionError(
            f"a session document cannot be called {clash[0]!r}: the format uses that name"
        )
    names = [run.name for run in plan.runs]
    if not names or not plan.channels:
        raise SessionError("a session needs at least one run and one channel")
    if (
        len(set(names)) < len(names)
        or "session" in names
        or not all(map(RUN_NAME.fullmatch, names))
    ):
        allowed = "of letters, digits, _, - and . (neither of these two first), and not 'session'"
        raise SessionError(f"run names must be different, {allowed}")
    if any(run.samples < 1 or run.blocks < 1 for run in plan.runs):
        raise SessionError("every run needs room for at least one sample and one block")
    unknown = sorted(
        {run.condition for run in plan.runs}
        - {str(condition["id"]) for condition in plan.conditions}
    )
    if unknown:
        raise SessionError(
            f"a run names the condition {unknown[0]!r}, which the plan does not list"
        )


def _resolved(run: RunPlan, plan: SessionPlan) -> RunPlan:
    """Return the run with the session's rate and ledger length where it has none of its own."""
    cycles = plan.ledger_cycles if run.ledger_cycles is None else run.ledger_cycles
    return dataclasses.replace(run, rate=float(run.rate or plan.rate), ledger_cycles=cycles)


def _run(root: Any, run: RunPlan, plan: SessionPlan) -> None:
    entry = group(root, run.name, run_attributes(run))
    data = group(entry, "data", data_attributes(plan.channels))
    for channel in plan.channels:
        codes = array(data, channel.name, "<i4", (run.samples,), chunk=min(CHUNK, run.samples))
        attributes(codes, signal_attributes(channel))
    array(entry, "blocks", block_dtype(len(plan.channels)), (run.blocks,))
    if plan.scalars:
        scalars = array(entry, "scalars", "<f8", (len(plan.scalars),))
        attributes(scalars, {"names": plan.scalars})
    if plan.synthetic and plan.ledger_columns:
        truth = group(entry, "truth", {"NX_class": "NXcollection"})
        ledger = array(truth, "ledger", "<f8", (run.ledger_cycles or 0, len(plan.ledger_columns)))
        attributes(ledger, {"columns": plan.ledger_columns, "units": "J"})


def run_attributes(run: RunPlan) -> dict[str, AttributeValue]:
    """Return the attributes of a run's group."""
    return {
        "NX_class": "NXentry",
        "default": "data",
        "title": run.title or f"{run.condition}, repeat {run.repeat}",
        "condition": run.condition,
        "repeat": run.repeat,
        "order": run.order,
        "rate": float(run.rate or 0.0),
        "t0": run.t0,
        "settle_samples": run.settle_samples,
    }


def data_attributes(channels: Sequence[ChannelInfo]) -> dict[str, AttributeValue]:
    """Return the attributes of a run's `data` group: viewers plot the first channel."""
    names = [channel.name for channel in channels]
    found: dict[str, AttributeValue] = {"NX_class": "NXdata", "signal": names[0], "axes": "."}
    return found | {"auxiliary_signals": names[1:]} if names[1:] else found


def signal_attributes(channel: ChannelInfo) -> dict[str, AttributeValue]:
    """Return the attributes of a channel's codes."""
    return {
        "units": channel.unit,
        "scale": channel.scale,
        "offset": channel.offset,
        "sensitivity": channel.sensitivity,
        "long_name": f"{channel.quantity}: (code * scale + offset) / sensitivity",
    }


def channel_attributes(channel: ChannelInfo, position: int) -> dict[str, AttributeValue]:
    """Return the attributes of a channel's group in the channel table; a missing time constant is
    infinite, its corner 0 Hz.
    """
    values = dataclasses.asdict(channel)
    values["time_constant"] = (
        float("inf") if channel.time_constant is None else channel.time_constant
    )
    return {"NX_class": "NXsensor", "position": position, **values, "pole_Hz": channel.pole_Hz}


def _json(name: str, value: Any) -> str:
    try:
        return json.dumps(value, ensure_ascii=False, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise SessionError(
            f"the session document {name!r} cannot be written as JSON: {error}"
        ) from error
