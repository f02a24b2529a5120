"""List every deviation of a session file from its format (docs/session-format.md); a reader stops
at the first.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from daq.chain.block import Flag
from daq.session.layout import (
    ROOT_NAMES,
    channel_attributes,
    data_attributes,
    run_attributes,
    signal_attributes,
)
from daq.session.plan import CHUNK, RunPlan, SessionError
from daq.session.record import Record

__all__ = ["session_deviations"]

DOCUMENTS = ("conditions", "protocol", "runs", "scalars")


def session_deviations(record: Record) -> Iterator[str]:
    """Yield one sentence per deviation from a session as this version writes it.

    Includes deviations that `open_session` tolerates. Documents must be JSON here; their content is
    checked by analysis.session.documents.
    """
    checks = [_entry(record), _documents(record), _channels(record), _truth(record)]
    for check in (*checks, *(_run(record, plan) for plan in record.plans)):
        try:
            yield from check
        except SessionError as error:
            yield str(error)


def _entry(record: Record) -> Iterator[str]:
    root = record.attributes("")
    yield from _differing("the root", root, {"NX_class": "NXroot"})
    if root.get("default") not in {plan.name for plan in record.plans}:
        yield f"the root's default is {root.get('default')!r}, expected the name of a run"
    for name in sorted(ROOT_NAMES - set(root)):
        yield f"the root has no attribute {name}"
    yield from _differing("session", record.attributes("session"), {"NX_class": "NXentry"})
    if not record.protocol_text and record.synthetic:
        yield "session/protocol_text is empty in a synthetic session"


def _documents(record: Record) -> Iterator[str]:
    for name in DOCUMENTS:
        if name not in record.documents:
            yield f"session/{name} is missing, or no text"
    for name in record.documents:
        yield from _raised(lambda name=name: record.document(name))  # type: ignore[misc]
    if "conditions" in record.documents:
        yield from _raised(lambda: record.conditions)


def _channels(record: Record) -> Iterator[str]:
    for position, channel in enumerate(record.channels.values()):
        place = f"session/channels/{channel.name}"
        yield from _differing(
            place, record.attributes(place), channel_attributes(channel, position)
        )


def _truth(record: Record) -> Iterator[str]:
    truth = record.truth
    if (truth is not None) != record.synthetic:
        yield f"synthetic is {record.synthetic}, and session/truth is {'missing' if truth is None else 'there'}"
    if truth is not None:
        for name in truth.documents:
            yield from _raised(lambda name=name: truth.document(name))  # type: ignore[misc]


def _run(record: Record, plan: RunPlan) -> Iterator[str]:
    """Yield the deviations of a run, reading all its attributes, tables and codes."""
    info = record.run(plan.name)
    yield from _differing(plan.name, record.attributes(plan.name), run_attributes(plan))
    channels = tuple(record.channels.values())
    yield from _differing(
        f"{plan.name}/data", record.attributes(f"{plan.name}/data"), data_attributes(channels)
    )
    for channel in channels:
        place = f"{plan.name}/data/{channel.name}"
        yield from _differing(place, record.attributes(place), signal_attributes(channel))
        for start in range(0, info.samples, CHUNK):
            record.codes(plan.name, channel.name, start, min(start + CHUNK, info.samples))
    seen = int(np.bitwise_or.reduce(record.blocks(plan.name)["flags"], axis=None, initial=0))
    # NOT_SETTLED is normal in the first blocks and is not part of a run's flags.
    missing = seen & ~info.flags & ~Flag.NOT_SETTLED
    if missing:
        yield f"session/status: {plan.name} lacks flags that its blocks have: {missing:#x}"
    if record.scalar_names:
        names = {"names": record.scalar_names}
        yield from _differing(
            f"{plan.name}/scalars", record.attributes(f"{plan.name}/scalars"), names
        )
        record.scalars(plan.name)
    if record.synthetic and record.ledger_columns:
        place, columns = (
            f"{plan.name}/truth/ledger",
            {"columns": record.ledger_columns, "units": "J"},
        )
        yield from _differing(place, record.attributes(place), columns)
        record.ledger_rows(plan.name)


def _raised(read: Callable[[], object]) -> Iterator[str]:
    """Yield the message of the SessionError that a read raises, if any."""
    try:
        read()
    except SessionError as error:
        yield str(error)


def _differing(place: str, found: Mapping[str, Any], expected: Mapping[str, Any]) -> Iterator[str]:
    """Yield a sentence for each expected attribute that is missing or different; further attributes
    are allowed.
    """
    for name, value in expected.items():
        if name not in found:
            yield f"{place} has no attribute {name}"
        elif not _equal(found[name], tuple(value) if isinstance(value, list) else value):
            yield f"{place}: the attribute {name} is {found[name]!r}, expected {value!r}"


def _equal(one: Any, other: Any) -> bool:
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=1e-12)
    return type(one) is type(other) and bool(one == other)
