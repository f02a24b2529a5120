"""Read a session: the interface between acquisition and analysis."""

from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from daq.chain.channel import ChannelInfo
from daq.documents.shapes import LARGEST, Keys, List, Text, YesNo, deviations
from daq.regular_files import kind_of_place
from daq.session.content import (
    RATE,
    block_deviations,
    channel_deviations,
    channel_of,
    condition_deviations,
    plans_of,
    read_channel_rows,
    read_json,
    refuse,
    status_deviations,
)
from daq.session.hdf5 import dataset, has, read_attributes, read_text
from daq.session.plan import (
    SCHEMA,
    ChannelSignal,
    RunInfo,
    RunPlan,
    SessionError,
    block_dtype,
    run_info,
    status_dtype,
)
from daq.session.session_file import SessionFile, opened

__all__ = ["Record", "SessionTruth", "open_session"]

Codes = npt.NDArray[np.int32]


def open_session(path: Path | str, patience: float | None = None) -> "Record":
    """Open a session file for reading, also while it is written or after its writer was killed.

    patience: seconds that the HDF5 library may take for one call before SIGALRM ends the process,
    None for no limit. Meant for a process watched by its parent, because some damaged files make
    the library hang or crash.

    Raises SessionError where there is no such file, or it is not an intact session of this schema.
    """
    place = Path(path)
    if not place.is_file():
        kind = kind_of_place(place)
        if kind:
            raise SessionError(f"{place} is {kind}, no session file")
        raise SessionError(f"there is no session file {place}")
    file = opened(place, patience)
    try:
        return Record(file, place, patience)
    except BaseException:
        with suppress(OSError, RuntimeError):
            file.close()
        raise


class Record(SessionFile):
    """A session as the analysis sees it, from `open_session` or `Recorder.record`.

    Any thread may read. Raises SessionError for any content that deviates from the format.

    status_rows : the status table as last read; a recorder keeps its own record's up to date
    """

    def __init__(
        self, file: Any, path: Path, patience: float | None = None, made: bool = False
    ) -> None:
        super().__init__(file, path, patience, made)
        self._known_blocks: tuple[str, npt.NDArray[np.void]] | None = None
        self._known_scalars: tuple[str, dict[str, float]] | None = None
        self._documents: dict[str, Any] = {}
        with self.readable():
            root = read_attributes(file, "")
            self.schema = str(root.get("schema", "none"))
            if self.schema != SCHEMA:
                raise SessionError(f"{path} {_foreign(self.schema)}")
            refuse(deviations(root, Keys({"synthetic": YesNo()}), "the root's attributes"))
            self.synthetic = bool(root["synthetic"])
            refuse(deviations(read_attributes(file, "session"), Keys({"rate": RATE}), "session"))
            self.rate = float(read_attributes(file, "session")["rate"])
            self._plans = plans_of(read_json(file, "session/runs"))
            self._index = {name: position for position, name in enumerate(self._plans)}
            names = read_json(file, "session/scalars")
            refuse(deviations(names, List(Text()), "session/scalars"))
            self._scalar_names = tuple(names)
            self.status_rows = self._status_rows()

    @property
    def runs(self) -> tuple[RunInfo, ...]:
        """All runs in the order of the plan, with their present state."""
        rows = self._status_rows() if self._live else self.status_rows
        return tuple(
            run_info(plan, row) for plan, row in zip(self._plans.values(), rows, strict=True)
        )

    def run(self, name: str) -> RunInfo:
        """Return one run, with its present state."""
        status = self._status(name)  # refuses unknown names
        return run_info(self._plans[name], status)

    @property
    def plans(self) -> tuple[RunPlan, ...]:
        """The plans of all runs, in their order."""
        return tuple(self._plans.values())

    @property
    def complete(self) -> bool:
        """Whether every run is complete."""
        return all(run.complete for run in self.runs)

    @cached_property
    def conditions(self) -> dict[str, dict[str, Any]]:
        """Conditions by id, in the order of the plan."""
        with self.readable():
            conditions = read_json(self._file, "session/conditions")
            refuse(deviations(conditions, List(Keys({"id": Text()})), "session/conditions"))
            found = {condition["id"]: condition for condition in conditions}
            refuse(condition_deviations(self._plans, found))
            return found

    @cached_property
    def channels(self) -> dict[str, ChannelInfo]:
        """The channel table by name, in row order."""
        with self.readable():
            rows = read_channel_rows(self._file)
            refuse(channel_deviations(rows))
            ordered = sorted(rows.values(), key=lambda row: int(row["position"]))
            return {info.name: info for info in map(channel_of, ordered)}

    @cached_property
    def protocol_text(self) -> str:
        """The protocol file, verbatim."""
        with self.readable():
            return read_text(dataset(self._file, "session/protocol_text"))

    @cached_property
    def ledger_columns(self) -> tuple[str, ...]:
        """Column names of the ledgers, the same for every run; empty for a record without truth or
        runs.
        """
        for run in self._plans:
            if has(self._file, f"{run}/truth/ledger"):
                columns = self.attributes(f"{run}/truth/ledger").get("columns")
                if not isinstance(columns, tuple) or not all(
                    isinstance(name, str) for name in columns
                ):
                    raise SessionError(
                        f"{self._path} is damaged: {run}/truth/ledger does not name its columns"
                    )
                return columns
        return ()

    @cached_property
    def truth(self) -> "SessionTruth | None":
        """Data that only a simulation can know; None for records without it."""
        with self.readable():
            return SessionTruth(self) if has(self._file, "session/truth") else None

    @property
    def scalar_names(self) -> tuple[str, ...]:
        """Names of the floats stored at the end of every run."""
        return self._scalar_names

    @property
    def documents(self) -> tuple[str, ...]:
        """Names of the session's JSON documents."""
        return tuple(name for name in self.texts("session") if name != "protocol_text")

    def document(self, name: str) -> Any:
        """Return the JSON value of a session document ("prediction", "rig", "protocol"...), None
        where there is none.

        Returns the same object every time.
        """
        if name not in self._documents:
            self._documents[name] = self.json_or_none(f"session/{name}")
        return self._documents[name]

    def signal(self, run: str, name: str, start: int = 0, stop: int | None = None) -> ChannelSignal:
        """Return samples start..stop (default: all valid ones) of a channel in engineering units,
        by its certified sensitivity.
        """
        first, last = self._within(run, self._status(run), start, stop)
        return self.signal_of(
            run, name, first, self._codes(run, self._channel(name).name, first, last)
        )

    def signal_of(self, run: str, name: str, start: int, codes: Codes) -> ChannelSignal:
        """Return the signal, as `signal` does, of codes of a channel that were read before; the
        first is sample `start`.
        """
        channel, status = self._channel(name), self._status(run)
        first, last = start, start + codes.size
        samples = codes.astype(np.float64)
        # In place: a record may be hundreds of MB.
        samples *= channel.scale / channel.sensitivity
        if channel.offset:
            samples += channel.offset / channel.sensitivity
        blocks = self._blocks(run, status)
        touched = (
            (blocks["start"] < last) & (blocks["start"] + blocks["count"] > first) & (first < last)
        )
        flags = np.bitwise_or.reduce(blocks["flags"][touched, self._columns[name]], initial=0)
        return ChannelSignal(
            samples, float(self._plans[run].rate or self.rate), channel.unit, int(flags)
        )

    def codes(self, run: str, name: str, start: int = 0, stop: int | None = None) -> Codes:
        """Return converter codes start..stop (default: all valid ones) of a channel, int32."""
        first, last = self._within(run, self._status(run), start, stop)
        return self._codes(run, self._channel(name).name, first, last)

    def all_codes(self, run: str, start: int, stop: int) -> Codes:
        """Return converter codes start..stop of every channel, (channels, samples) in row order."""
        first, last = self._within(run, self._status(run), start, stop)
        codes = np.empty((len(self.channels), last - first), np.int32)
        for row, name in zip(codes, self.channels, strict=True):
            with self.readable():
                self._table(f"{run}/data/{name}", "<i4", (self._plans[run].samples,)).read_into(
                    row, first
                )
        return codes

    def blocks(self, run: str) -> npt.NDArray[np.void]:
        """Return the blocks recorded so far: start, count, flags and clipped (one column per
        channel).
        """
        return self._blocks(run, self._status(run))

    def scalars(self, run: str) -> dict[str, float]:
        """Return the floats stored at the end of a run, by name; empty for an incomplete run."""
        if not self._scalar_names or not self._status(run)["complete"]:
            return {}
        if self._known_scalars is None or self._known_scalars[0] != run:
            values = self._rows(f"{run}/scalars", "<f8", (len(self._scalar_names),))
            if (np.abs(values) > LARGEST).any():
                raise SessionError(f"{self._path} is damaged: {run}/scalars holds absurd numbers")
            self._known_scalars = run, dict(zip(self._scalar_names, values.tolist(), strict=True))
        return dict(self._known_scalars[1])

    def ledger_cycles(self, run: str) -> int:
        """Return the number of cycles for which a run's ledger has room."""
        return self._plans[run].ledger_cycles or 0

    def ledger_rows(
        self, run: str, start: int = 0, stop: int | None = None
    ) -> npt.NDArray[np.float64]:
        """Return rows start..stop of a run's ledger, clipped to its length, (cycles, columns)."""
        self._status(run)  # refuses unknown names
        cycles = self.ledger_cycles(run)
        last = cycles if stop is None else min(stop, cycles)
        path, shape = f"{run}/truth/ledger", (cycles, len(self.ledger_columns))
        rows = self._rows(path, "<f8", shape, min(start, last), last)
        if (np.abs(rows) > LARGEST).any():  # NaN is allowed, for unknown numbers
            raise SessionError(f"{self._path} is damaged: {run}/truth/ledger holds absurd numbers")
        return rows

    def _codes(self, run: str, channel: str, start: int, stop: int) -> Codes:
        return self._rows(f"{run}/data/{channel}", "<i4", (self._plans[run].samples,), start, stop)

    def _status_rows(self) -> npt.NDArray[np.void]:
        rows = self._rows("session/status", status_dtype, (len(self._plans),))
        with self.readable():
            refuse(status_deviations(self._plans, rows))
        return rows

    def _status(self, run: str) -> Any:
        if run not in self._index:
            raise SessionError(f"{self._path} has no run {run!r}")
        index = self._index[run]
        return self._status_rows()[index] if self._live else self.status_rows[index]

    def _blocks(self, run: str, status: Any) -> npt.NDArray[np.void]:
        """Return the block rows so far; those of the last complete run are cached."""
        if self._known_blocks is not None and self._known_blocks[0] == run:
            return self._known_blocks[1]
        shape = (self._plans[run].blocks,)
        rows = self._rows(
            f"{run}/blocks", block_dtype(len(self.channels)), shape, 0, int(status["blocks"])
        )
        with self.readable():
            refuse(block_deviations(run, int(status["samples"]), rows))
        if status["complete"]:
            self._known_blocks = (run, rows)
        return rows

    def _within(self, run: str, status: Any, start: int, stop: int | None) -> tuple[int, int]:
        valid = int(status["samples"])
        last = valid if stop is None else stop
        if not 0 <= start <= last <= valid:
            raise SessionError(f"{run} has {valid} valid samples; {start} to {last} was asked for")
        return start, last

    @cached_property
    def _columns(self) -> dict[str, int]:
        """Columns of the block tables, by channel."""
        return {name: column for column, name in enumerate(self.channels)}

    def _channel(self, name: str) -> ChannelInfo:
        if name not in self.channels:
            raise SessionError(f"no channel {name!r}; the session has {', '.join(self.channels)}")
        return self.channels[name]


class SessionTruth:
    """The simulation's own account of a session, which no laboratory record has."""

    def __init__(self, record: Record) -> None:
        self._record = record

    @property
    def documents(self) -> tuple[str, ...]:
        """Names of the truth documents."""
        return self._record.texts("session/truth")

    def ledger(
        self, run: str, start: int = 0, stop: int | None = None
    ) -> tuple[tuple[str, ...], npt.NDArray[np.float64]]:
        """Return (column names, rows start..stop of the ledger, clipped to its length).

        Rows: (cycles, columns), J per cycle, counted from drive time 0.
        """
        return self._record.ledger_columns, self._record.ledger_rows(run, start, stop)

    def document(self, name: str) -> Any:
        """Return the JSON value of a truth document, None where there is none."""
        return self._record.json_or_none(f"session/truth/{name}")


def _foreign(schema: str) -> str:
    """Return the reason why a file of another schema is not read."""
    family, _, version = SCHEMA.rpartition("/")
    other, _, found = schema.rpartition("/")
    if other == family and found.isdecimal() and int(found) > int(version):
        return f"was written by a newer version (schema {schema}, this one reads {SCHEMA}): update this program"
    return f"is not a session: its schema is {schema}, expected {SCHEMA}"
