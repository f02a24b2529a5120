"""Reading a session: the waist between acquisition and analysis."""

import dataclasses
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt

from daq.channel import ChannelInfo
from daq.session_hdf5 import (
    dataset,
    has,
    is_text,
    members,
    open_for_reading,
    read_attributes,
    read_rows,
    read_text,
)
from daq.session_plan import SCHEMA, RunInfo, RunPlan, SessionError, Signal, block_dtype, run_info, status_dtype

__all__ = ["Record", "Truth", "open_session"]

Codes = npt.NDArray[np.int32]


def open_session(path: Path | str) -> "Record":
    """Open a session file for reading, also while it is written or after its writer was killed.

    Raises SessionError where there is no such file, or it is not an intact session of this schema.
    """
    place = Path(path)
    if not place.is_file():
        raise SessionError(f"there is no session file {place}")
    try:
        file = open_for_reading(place)
    except (OSError, RuntimeError, ValueError) as error:
        raise SessionError(f"{place} is not a readable HDF5 file: {error}") from error
    try:
        return Record(file, place)
    except BaseException:
        file.close()
        raise


class Record:
    """A session as the analysis sees it; `open_session` or `Recorder.record` gives one. Any thread may read.

    `status_rows` is the status table as last read; a recorder keeps its own record's up to date.

    Raises SessionError for anything that the file does not hold as it should. Only hard links are followed, so that a
    foreign file cannot point the reader at other files.
    """

    def __init__(self, file: Any, path: Path) -> None:
        self._file = file
        self._path = path
        self._owned = file.mode == "r"  # a recorder keeps its own file
        self._live = self._owned and file.swmr_mode  # another process may be writing
        with self.readable():
            root = read_attributes(file, "")
            self.schema = str(root.get("schema", "none"))
            if self.schema != SCHEMA:
                raise SessionError(f"{path} is not a session: its schema is {self.schema}, expected {SCHEMA}")
            self.synthetic = bool(root["synthetic"])
            self.rate = float(read_attributes(file, "session")["rate"])
            self._plans = {str(row["name"]): RunPlan(**row) for row in self._json("session/runs")}
            self._index = {name: position for position, name in enumerate(self._plans)}
            self._scalar_names = tuple(str(name) for name in self._json("session/scalars"))
            self.status_rows = self.rows("session/status", status_dtype, 0)
            if self.status_rows.shape != (len(self._plans),):
                raise SessionError(f"{path} is damaged: its status table does not match its list of runs")

    def __enter__(self) -> "Record":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; a recorder's own record stays open with its recorder."""
        if self._owned:
            self._file.close()

    @property
    def runs(self) -> tuple[RunInfo, ...]:
        """All runs in the order of the plan, with what is valid now."""
        rows = self.rows("session/status", status_dtype, 0) if self._live else self.status_rows
        return tuple(run_info(plan, row) for plan, row in zip(self._plans.values(), rows, strict=True))

    def run(self, name: str) -> RunInfo:
        """One run, with what is valid now."""
        status = self._status(name)  # refuses unknown names
        return run_info(self._plans[name], status)

    @property
    def plans(self) -> tuple[RunPlan, ...]:
        """What was planned of every run, in the order of the plan."""
        return tuple(self._plans.values())

    @property
    def complete(self) -> bool:
        """Whether every run is complete."""
        return all(run.complete for run in self.runs)

    @cached_property
    def conditions(self) -> dict[str, dict[str, Any]]:
        """Conditions by id, in the order of the plan."""
        with self.readable():
            return {str(condition["id"]): condition for condition in self._json("session/conditions")}

    @cached_property
    def channels(self) -> dict[str, ChannelInfo]:
        """The channel table by name, in row order."""
        with self.readable():
            if not has(self._file, "session/channels"):
                raise KeyError("session/channels is missing")
            names = list(self._file["session/channels"])
            rows = [read_attributes(self._file, f"session/channels/{name}") for name in names]
            rows.sort(key=lambda row: int(row["position"]))
            return {info.name: info for info in map(_channel_info, rows)}

    @cached_property
    def protocol_text(self) -> str:
        """The protocol file, verbatim."""
        with self.readable():
            return read_text(dataset(self._file, "session/protocol_text"))

    @cached_property
    def ledger_columns(self) -> tuple[str, ...]:
        """Column names of the ledgers, the same for every run; empty for a record without truth or runs."""
        for run in self._plans:
            if has(self._file, f"{run}/truth/ledger"):
                return tuple(str(name) for name in self.attributes(f"{run}/truth/ledger")["columns"])
        return ()

    @property
    def truth(self) -> "Truth | None":
        """What only a simulation can know; None for records without it."""
        with self.readable():
            return Truth(self) if has(self._file, "session/truth") else None

    @property
    def documents(self) -> tuple[str, ...]:
        """Names of the session's JSON documents."""
        return tuple(name for name in self.texts("session") if name != "protocol_text")

    def document(self, name: str) -> Any:
        """The JSON value of a session document ("prediction", "rig", "protocol"...), None where there is none."""
        return self.json_or_none(f"session/{name}")

    def signal(self, run: str, name: str, start: int = 0, stop: int | None = None) -> Signal:
        """Samples start..stop (default: all valid ones) of a channel in engineering units, certified sensitivity."""
        channel, status = self._channel(name), self._status(run)
        first, last = self._within(run, status, start, stop)
        samples = self.rows(f"{run}/data/{name}", "<i4", first, last).astype(np.float64)
        samples *= channel.scale / channel.sensitivity
        if channel.offset:
            samples += channel.offset / channel.sensitivity
        blocks = self._blocks(run, status)
        touched = (blocks["start"] < last) & (blocks["start"] + blocks["count"] > first) & (first < last)
        flags = np.bitwise_or.reduce(blocks["flags"][touched, self._column(name)], initial=0)
        return Signal(samples, float(self._plans[run].rate or self.rate), channel.unit, int(flags))

    def codes(self, run: str, name: str, start: int = 0, stop: int | None = None) -> Codes:
        """Converter codes start..stop (default: all valid ones) of a channel, int32."""
        first, last = self._within(run, self._status(run), start, stop)
        return self.rows(f"{run}/data/{self._channel(name).name}", "<i4", first, last)

    def blocks(self, run: str) -> npt.NDArray[np.void]:
        """The blocks recorded so far: start, count, flags and clipped (one column per channel)."""
        return self._blocks(run, self._status(run))

    def scalars(self, run: str) -> dict[str, float]:
        """The floats that the run ended with, by name; empty where it is not complete."""
        if not self._scalar_names or not self._status(run)["complete"]:
            return {}
        values = self.rows(f"{run}/scalars", "<f8", 0, len(self._scalar_names))
        return dict(zip(self._scalar_names, values.tolist(), strict=True))

    def rows(self, path: str, dtype: npt.DTypeLike, start: int, stop: int | None = None) -> npt.NDArray[Any]:
        """Rows of a dataset of the session (default: to its end) as `dtype`, as they are now."""
        with self.readable():
            source = dataset(self._file, path)
            if self._live:
                source.refresh()
            return read_rows(source, dtype, start, source.shape[0] if stop is None else stop)

    def attributes(self, path: str) -> dict[str, Any]:
        """Attributes of a group or dataset of the session."""
        with self.readable():
            return read_attributes(self._file, path)

    def texts(self, path: str) -> tuple[str, ...]:
        """Names of the datasets in a group, sorted, that hold text; "" for none."""
        with self.readable():
            return tuple(name for name in members(self._file, path) if is_text(self._file, f"{path}/{name}"))

    def json_or_none(self, path: str) -> Any:
        """The JSON value of the text dataset at `path`, None where there is none."""
        with self.readable():
            return self._json(path) if has(self._file, path) else None

    @contextmanager
    def readable(self) -> Iterator[None]:
        """Turn what h5py and the decoders raise on a foreign or damaged file into a SessionError."""
        try:
            yield
        except (OSError, RuntimeError, KeyError, ValueError, TypeError, IndexError, AttributeError) as error:
            raise SessionError(f"{self._path} is damaged or not a session: {error}") from error

    def _json(self, path: str) -> Any:
        return json.loads(read_text(dataset(self._file, path)))

    def _status(self, run: str) -> Any:
        if run not in self._index:
            raise SessionError(f"{self._path} has no run {run!r}")
        index = self._index[run]
        if self._live:
            return self.rows("session/status", status_dtype, index, index + 1)[0]
        return self.status_rows[index]

    def _blocks(self, run: str, status: Any) -> npt.NDArray[np.void]:
        return self.rows(f"{run}/blocks", block_dtype(len(self.channels)), 0, int(status["blocks"]))

    def _within(self, run: str, status: Any, start: int, stop: int | None) -> tuple[int, int]:
        valid = int(status["samples"])
        last = valid if stop is None else stop
        if not 0 <= start <= last <= valid:
            raise SessionError(f"{run} has {valid} valid samples; {start} to {last} was asked for")
        return start, last

    def _column(self, name: str) -> int:
        return list(self.channels).index(name)

    def _channel(self, name: str) -> ChannelInfo:
        if name not in self.channels:
            raise SessionError(f"no channel {name!r}; the session has {', '.join(self.channels)}")
        return self.channels[name]


class Truth:
    """The simulation's own account; nothing that a laboratory record has."""

    def __init__(self, record: Record) -> None:
        self._record = record

    @property
    def documents(self) -> tuple[str, ...]:
        """Names of the truth documents."""
        return self._record.texts("session/truth")

    def ledger(self, run: str) -> tuple[tuple[str, ...], npt.NDArray[np.float64]]:
        """Column names and the ledger, (cycles, columns), J per cycle counted from drive time 0."""
        path = f"{self._record.run(run).name}/truth/ledger"
        return self._record.ledger_columns, self._record.rows(path, "<f8", 0)

    def document(self, name: str) -> Any:
        """The JSON value of a truth document, None where there is none."""
        return self._record.json_or_none(f"session/truth/{name}")


def _channel_info(attributes: Mapping[str, Any]) -> ChannelInfo:
    """A row of the channel table from its attributes; an infinite time constant means a response down to DC.

    Fields with a default may be missing: sessions from before they were there have none.
    """
    values: dict[str, Any] = {}
    for field in dataclasses.fields(ChannelInfo):
        if field.name not in attributes and field.default is not dataclasses.MISSING:
            continue
        value = attributes[field.name]
        values[field.name] = value if isinstance(value, str) else float(value)
    if not np.isfinite(values["time_constant"]):
        values["time_constant"] = None
    return ChannelInfo(**values)
