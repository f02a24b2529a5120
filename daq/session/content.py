"""The required content of a session: plans, channel table, status and block tables, and deviations
from it.
"""

import dataclasses
import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from daq.chain.block import Flag
from daq.chain.channel import ChannelInfo
from daq.documents.shapes import Keys, List, Number, Text, deviations
from daq.session.hdf5 import dataset, members, read_attributes, read_text
from daq.session.plan import RUN_NAME, RunPlan

__all__ = [
    "CHANNEL",
    "RATE",
    "RUNS",
    "block_deviations",
    "channel_deviations",
    "channel_of",
    "condition_deviations",
    "plan_deviations",
    "plans_of",
    "read_channel_rows",
    "read_json",
    "refuse",
    "status_deviations",
]

COUNT = Number(0, whole=True)
POSITIVE = Number(0.0, above=True)
RATE = Number(1e-6)  # Hz; below it, samples per cycle vanish and quotients by them overflow
NO_FLAGS = ~np.uint16(sum(Flag))  # bits of a block's flags that mean nothing
SMALLEST = 1e-15  # V per unit, V: dividing by a smaller scale could overflow

RUNS = List(
    Keys(
        {
            "name": Text(),
            "condition": Text(),
            "repeat": Number(whole=True),
            "order": Number(whole=True),
            "samples": Number(1, whole=True),
            "settle_samples": COUNT,
            "blocks": Number(1, whole=True),
        },
        {
            "t0": Text(),
            "title": Text(),
            "rate": RATE,
            "ledger_cycles": Number(0, whole=True, null=True),
        },
    ),
    least=1,
)
"""`session/runs`: the plan of every run."""

_SPECIAL = {
    "scale": Number(SMALLEST),
    "time_constant": Number(0.0, above=True, null=True),
    "range_V": POSITIVE,
    **dict.fromkeys(
        ("time_constant_spread", "calibration_U", "gain_tolerance", "clock_ppm", "noise_rms"),
        Number(0.0),
    ),
}
_FIELDS = {
    item.name: _SPECIAL.get(item.name, Text() if item.type is str else Number())
    for item in dataclasses.fields(ChannelInfo)
}
_DEFAULTED = {
    item.name for item in dataclasses.fields(ChannelInfo) if item.default is not dataclasses.MISSING
}
CHANNEL = Keys(
    {
        "position": COUNT,
        **{name: shape for name, shape in _FIELDS.items() if name not in _DEFAULTED},
    },
    {name: shape for name, shape in _FIELDS.items() if name in _DEFAULTED},
)
"""Attributes of a group of `session/channels`.

A time constant is null here where the file holds an infinite one.
"""


def refuse(found: Iterable[str]) -> None:
    """Raise ValueError with the first deviation, if there is any."""
    for sentence in found:
        raise ValueError(sentence)


def read_json(file: Any, path: str) -> Any:
    """Return the JSON value of a text dataset.

    Raises ValueError where it is not JSON; NaN, Infinity and lone surrogates are not allowed.
    """
    source = read_text(dataset(file, path))
    value = json.loads(source, parse_constant=_no_constant)
    # only an escape can hold a lone surrogate, which cannot be encoded as UTF-8
    if "\\u" in source:
        json.dumps(value, ensure_ascii=False).encode()
    return value


def _no_constant(word: str) -> Any:
    raise ValueError(f"{word} is no JSON number")


def plan_deviations(runs: Any) -> Iterator[str]:
    """Yield a sentence for each deviation of the plans of the runs (the JSON value of
    `session/runs`).
    """
    found = list(deviations(runs, RUNS, "session/runs"))
    yield from found
    if found:
        return
    names = [run["name"] for run in runs]
    if len(set(names)) < len(names):
        yield "session/runs names a run twice"
    for name in names:
        if name == "session" or not RUN_NAME.fullmatch(name):
            allowed = (
                "letters, digits, _, - and ., starting with a letter, a digit or _; not session"
            )
            yield f"session/runs has a run called {ascii(name)[:60]}, allowed are {allowed}"


def plans_of(runs: Any) -> dict[str, RunPlan]:
    """Return the plans by name.

    Raises ValueError for deviations; keys unknown to this version are ignored.
    """
    refuse(plan_deviations(runs))
    known = {item.name for item in dataclasses.fields(RunPlan)}
    plans = {}
    for run in runs:
        fields = {key: value for key, value in run.items() if key in known}
        plans[run["name"]] = RunPlan(**fields)
    return plans


def condition_deviations(plans: Mapping[str, RunPlan], conditions: Iterable[str]) -> Iterator[str]:
    """Yield a sentence for each run whose condition the session does not list."""
    known = set(conditions)
    for name, plan in plans.items():
        if plan.condition not in known:
            yield f"{name} is of the condition {plan.condition[:40]!r}, which session/conditions does not list"


def read_channel_rows(file: Any) -> dict[str, dict[str, Any]]:
    """Return the channel table as stored in the file: attributes by group name."""
    names = members(file, "session/channels")
    rows = {name: read_attributes(file, f"session/channels/{name}") for name in names}
    for row in rows.values():
        if row.get("time_constant") == np.inf:
            row["time_constant"] = None
    return rows


def channel_deviations(rows: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    """Yield a sentence for each deviation of the channel table."""
    for name, row in rows.items():
        place = f"session/channels/{name}"
        yield from deviations(row, CHANNEL, place)
        if row.get("name") != name:
            yield f"{place} calls itself {row.get('name')!r}"
        if (
            _FIELDS["sensitivity"].holds(row.get("sensitivity"))
            and abs(row["sensitivity"]) < SMALLEST
        ):
            yield f"{place}.sensitivity is {row['sensitivity']:g}, too small to divide by"
    if not rows:
        yield "session/channels is empty"
    positions = [row.get("position") for row in rows.values()]
    if set(positions) != set(range(len(rows))):
        yield "session/channels: the positions are not 0, 1, ... once each"


def channel_of(row: Mapping[str, Any]) -> ChannelInfo:
    """Return the ChannelInfo of a row of the channel table without deviations."""
    # HDF5 readers return whole numbers as int, but the fields are floats.
    given: dict[str, Any] = {name: row[name] for name in _FIELDS if name in row}
    numbers: dict[str, Any] = {
        name: float(value) for name, value in given.items() if isinstance(value, int)
    }
    return ChannelInfo(**{**given, **numbers})


def status_deviations(plans: Mapping[str, RunPlan], rows: npt.NDArray[np.void]) -> Iterator[str]:
    """Yield a sentence for each deviation of the status table, which has one row per plan."""
    for (name, plan), row in zip(plans.items(), rows, strict=True):
        if row["samples"] > plan.samples or row["blocks"] > plan.blocks:
            yield f"session/status: {name} has {row['samples']} samples in {row['blocks']} blocks, more than planned"
        if row["complete"] not in (0, 1) or (row["complete"] and row["samples"] != plan.samples):
            yield f"session/status: {name} is complete with {row['samples']} of {plan.samples} samples"


def block_deviations(run: str, samples: int, rows: npt.NDArray[np.void]) -> Iterator[str]:
    """Yield a sentence for each deviation in the block rows of a run with `samples` samples: blocks
    are consecutive from 0 on.
    """
    # Unsigned 64 bit throughout: counts from a foreign file must not wrap around to plausible
    # positions.
    ends = np.cumsum(rows["count"], dtype=np.uint64)
    if (rows["start"] != ends - rows["count"]).any() or (
        int(ends[-1]) if len(ends) else 0
    ) != samples:
        yield f"{run}/blocks: the blocks do not follow each other from sample 0 to {samples}"
    if (rows["clipped"] > rows["count"][:, np.newaxis]).any():
        yield f"{run}/blocks: more samples are clipped than there are"
    if (rows["flags"] & NO_FLAGS).any():
        yield f"{run}/blocks: flags that mean nothing"
