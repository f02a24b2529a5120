"""Reading a session: the waist between acquisition and analysis."""

import dataclasses
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from daq.channel import ChannelInfo
from daq.session_plan import SCHEMA, RunInfo, RunPlan, SessionError, Signal

__all__ = ["Record", "Truth", "open_session"]

Codes = npt.NDArray[np.int32]


def open_session(path: Path | str) -> "Record":
    """Open a session file for reading, also while it is written or after its writer was killed.

    Raises SessionError where there is no such file, or it is not an intact session of this schema.
    """
    place = str(path)
    if not Path(path).is_file():
        raise SessionError(f"there is no session file {place}")
    try:
        file = h5py.File(place, "r", libver="latest", swmr=True)
    except (OSError, RuntimeError, ValueError) as error:
        raise SessionError(f"{place} is not a readable HDF5 file: {error}") from error
    try:
        return Record(file, place)
    except BaseException:
        file.close()
        raise


class Record:
    """A session as the analysis sees it. Raises SessionError for anything that the file does not hold as it should.

    Only hard links are followed, so that a foreign file cannot point the reader at other files. Any thread may read.
    """

    def __init__(self, file: h5py.File, path: str) -> None:
        self._file = file
        self._path = path
        self._live = file.mode == "r"  # another process may be writing; a recorder's own handle sees its writes
        with self._readable():
            self.schema: str = _string(file.attrs.get("schema", ""))
            if self.schema != SCHEMA:
                raise SessionError(f"{path} is not a session: schema {self.schema!r}, expected {SCHEMA!r}")
            self.synthetic: bool = bool(file.attrs["synthetic"])
            self.rate: float = float(_child(file, "session").attrs["rate"])
            self._plans = {row["name"]: RunPlan(**row) for row in self._known("runs")}
            self._index = {name: position for position, name in enumerate(self._plans)}
            self._status = _dataset(file, "session/status")
            if self._status.shape != (len(self._plans),):
                raise SessionError(f"{path}: the status table does not match the list of runs")

    def __enter__(self) -> "Record":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; a recorder's own record stays open with its recorder."""
        if self._live:
            self._file.close()

    @property
    def runs(self) -> tuple[RunInfo, ...]:
        """All runs in the order of the plan, with what is valid now."""
        with self._readable():
            rows = self._fresh(self._status)[()]
            return tuple(_run_info(plan, row) for plan, row in zip(self._plans.values(), rows, strict=True))

    def run(self, name: str) -> RunInfo:
        """One run, with what is valid now."""
        if name not in self._index:
            raise SessionError(f"{self._path} has no run {name!r}")
        with self._readable():
            return _run_info(self._plans[name], self._fresh(self._status)[self._index[name]])

    @property
    def complete(self) -> bool:
        """Whether every run is complete."""
        return all(run.complete for run in self.runs)

    @cached_property
    def conditions(self) -> dict[str, dict[str, Any]]:
        """Conditions by id, in the order of the plan."""
        with self._readable():
            return {str(condition["id"]): condition for condition in self._known("conditions")}

    @cached_property
    def channels(self) -> dict[str, ChannelInfo]:
        """The channel table by name, in row order."""
        with self._readable():
            table = _child(self._file, "session/channels")
            attributes = [dict(_child(table, name).attrs) for name in table]
            attributes.sort(key=lambda row: int(row["position"]))
            return {info.name: info for info in map(_channel_info, attributes)}

    @cached_property
    def protocol_text(self) -> str:
        """The protocol file, verbatim."""
        with self._readable():
            return _string(_dataset(self._file, "session/protocol_text")[()])

    @property
    def truth(self) -> "Truth | None":
        """What only a simulation can know; None for records without it."""
        return Truth(self) if "truth" in _child(self._file, "session") else None

    def document(self, name: str) -> Any:
        """The JSON value of a session document ("prediction", "rig", "protocol"...), None where there is none."""
        return self._document(f"session/{name}")

    def signal(self, run: str, name: str, start: int = 0, stop: int | None = None) -> Signal:
        """Samples start..stop (default: all valid ones) of a channel in engineering units, certified sensitivity."""
        info = self.run(run)
        channel = self._channel(name)
        codes = self.codes(run, name, start, stop)
        samples = codes * (channel.scale / channel.sensitivity)
        if channel.offset:
            samples += channel.offset / channel.sensitivity
        flags = self._flags(run, name, start, start + len(codes))
        return Signal(samples, info.rate, channel.unit, flags)

    def codes(self, run: str, name: str, start: int = 0, stop: int | None = None) -> Codes:
        """Converter codes start..stop (default: all valid ones) of a channel, int32."""
        valid = self.run(run).samples
        last = valid if stop is None else stop
        if not 0 <= start <= last <= valid:
            raise SessionError(f"{run} has {valid} valid samples; {start} to {last} was asked for")
        with self._readable():
            data = self._fresh(_dataset(self._file, f"{run}/data/{self._channel(name).name}"))
            codes: Codes = np.asarray(data[start:last], dtype=np.int32)
        if len(codes) != last - start:
            raise SessionError(f"{self._path}: {run} holds fewer {name} samples than its status says")
        return codes

    def blocks(self, run: str) -> npt.NDArray[np.void]:
        """The blocks recorded so far: start, count, flags and clipped (one column per channel)."""
        with self._readable():
            used = int(self._fresh(self._status)[self._index[self.run(run).name]]["blocks"])
            blocks: npt.NDArray[np.void] = self._fresh(_dataset(self._file, f"{run}/blocks"))[:used]
            return blocks

    def scalars(self, run: str) -> dict[str, float]:
        """The floats that the run ended with, by name; empty where it is not complete."""
        names = self._known("scalars")
        if not names or not self.run(run).complete:
            return {}
        with self._readable():
            values = self._fresh(_dataset(self._file, f"{run}/scalars"))[()]
            return dict(zip(names, (float(value) for value in values), strict=True))

    def _flags(self, run: str, name: str, start: int, stop: int) -> int:
        blocks = self.blocks(run)
        row = list(self.channels).index(name)
        touched = (blocks["start"] < stop) & (blocks["start"] + blocks["count"] > start)
        return int(np.bitwise_or.reduce(blocks["flags"][touched, row], initial=0))

    def _channel(self, name: str) -> ChannelInfo:
        if name not in self.channels:
            raise SessionError(f"no channel {name!r}; the session has {', '.join(self.channels)}")
        return self.channels[name]

    def _fresh(self, dataset: Any) -> Any:
        if self._live:
            dataset.refresh()
        return dataset

    def _known(self, name: str) -> Any:
        value = self._document(f"session/{name}")
        if value is None:
            raise SessionError(f"{self._path} is not an intact session: {name} is missing")
        return value

    def _document(self, path: str) -> Any:
        with self._readable():
            parent, _, name = path.rpartition("/")
            if name not in _child(self._file, parent):
                return None
            return json.loads(_string(_dataset(self._file, path)[()]))

    @contextmanager
    def _readable(self) -> Iterator[None]:
        """Turn what h5py and the decoders raise on a foreign or damaged file into a SessionError."""
        try:
            yield
        except (OSError, RuntimeError, KeyError, ValueError, TypeError, IndexError, AttributeError) as error:
            raise SessionError(f"{self._path} is not an intact session: {error}") from error


class Truth:
    """The simulation's own account; nothing that a laboratory record has."""

    def __init__(self, record: Record) -> None:
        self._record = record

    def ledger(self, run: str) -> tuple[tuple[str, ...], npt.NDArray[np.float64]]:
        """Column names and the ledger, (cycles, columns), J per cycle counted from drive time 0."""
        record = self._record
        with record._readable():
            table = record._fresh(_dataset(record._file, f"{record.run(run).name}/truth/ledger"))
            return tuple(_string(name) for name in table.attrs["columns"]), np.asarray(table[()], dtype=np.float64)

    def document(self, name: str) -> Any:
        """The JSON value of a truth document, None where there is none."""
        return self._record._document(f"session/truth/{name}")


def _child(group: Any, path: str) -> Any:
    """The object at `path` below `group`, through hard links only."""
    for name in path.split("/"):
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            raise SessionError(f"{group.file.filename} is not an intact session: {group.name}/{name} is missing")
        group = group[name]
    return group


def _dataset(group: Any, path: str) -> Any:
    """The dataset at `path`, with its bytes in this file."""
    found = _child(group, path)
    if not isinstance(found, h5py.Dataset) or found.is_virtual or found.external:
        raise SessionError(f"{group.file.filename} is not an intact session: {path} is not a plain dataset")
    return found


def _string(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


def _run_info(plan: RunPlan, status: Any) -> RunInfo:
    return RunInfo(
        name=plan.name, condition=plan.condition, repeat=plan.repeat, order=plan.order,
        samples=int(status["samples"]), settle_samples=plan.settle_samples, complete=bool(status["complete"]),
        flags=int(status["flags"]), planned=plan.samples, rate=float(plan.rate or 0.0), t0=plan.t0, title=plan.title,
    )  # fmt: skip


def _channel_info(attributes: Mapping[str, Any]) -> ChannelInfo:
    """A row of the channel table from its attributes; a corner of 0 Hz (infinite time constant) means DC response."""
    values: dict[str, Any] = {}
    for field in dataclasses.fields(ChannelInfo):
        value = attributes[field.name]
        values[field.name] = _string(value) if isinstance(value, str | bytes) else float(value)
    if not np.isfinite(values["time_constant"]):
        values["time_constant"] = None
    return ChannelInfo(**values)
