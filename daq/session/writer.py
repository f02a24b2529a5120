"""Write a session: one HDF5 file, readable while it is written and after a kill.

The file is built complete under `<path>.part` (every group, every dataset, all space), switched to
HDF5's single-writer mode, flushed and renamed. From then on only samples, block rows, ledger rows
and the status table change, and data are flushed before the status row that counts them.
"""

import os
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt

from daq.chain.block import Block, Flag
from daq.session.disk_space import reserve
from daq.session.hdf5 import RowWriter, open_file
from daq.session.hdf5_flags import clear_consistency_flags
from daq.session.layout import build_session
from daq.session.plan import (
    SessionError,
    SessionPlan,
    WriteError,
    block_dtype,
    status_dtype,
)
from daq.session.record import Record
from daq.session.writer_lock import AlreadyLocked, WriterLock

__all__ = ["Recorder"]


class Recorder:
    """The only writer of a session file, to be called from one thread. Use `create` or `resume`."""

    def __init__(self, file: Any, path: Path, lock: WriterLock, made: bool = False) -> None:
        self._file = file
        self._path = path
        self._lock = lock
        self._record = Record(file, path, made=made)
        self._infos = {info.name: info for info in self._record.runs}
        self._index = {name: position for position, name in enumerate(self._infos)}
        self._channels = tuple(self._record.channels)
        self._scalar_names: tuple[str, ...] = tuple(self._record.document("scalars"))
        self._rows = self._record.status_rows
        self._open: dict[str, RowWriter] = {}
        self._failed = False

    @classmethod
    def create(cls, path: Path | str, plan: SessionPlan, overwrite: bool = False) -> "Recorder":
        """Create a session file with room for the whole plan.

        Raises SessionError where the path exists (with `overwrite` the old file stays until the new
        one is complete), is being written, or the plan cannot be stored; WriteError where the disk
        or folder refuses.
        """
        final = Path(path)
        if final.exists() and not overwrite:
            raise SessionError(f"{final} exists already")
        lock = _locked(final)
        part = final.with_name(final.name + ".part")
        try:
            part.unlink(missing_ok=True)  # a left-over, or a link to another file
            reserve(part, sum(4 * run.samples * len(plan.channels) for run in plan.runs))
            file = open_file(part, "w")
            try:
                build_session(file, plan)
                file.swmr_mode = True
                file.flush()
                reserve(part)
                # Readers see a complete file or none.
                os.replace(part, final)
                return cls(file, final, lock, made=True)
            except BaseException:
                file.close()
                raise
        except (OSError, RuntimeError) as error:
            part.unlink(missing_ok=True)
            lock.release()
            raise WriteError(f"cannot create the session {final}: {error}") from error
        except ValueError as error:
            part.unlink(missing_ok=True)
            lock.release()
            raise SessionError(f"cannot create the session {final}: {error}") from error
        except BaseException:
            part.unlink(missing_ok=True)
            lock.release()
            raise

    @classmethod
    def resume(cls, path: Path | str) -> "Recorder":
        """Resume an incomplete session, also after its writer was killed.

        Incomplete runs restart at sample 0.
        """
        final = Path(path)
        if not final.is_file():
            raise SessionError(f"there is no session file {final}")
        lock = _locked(final)
        try:
            # Safe under the lock: no live writer has the file open.
            clear_consistency_flags(final)
            file = open_file(final, "r+")
            try:
                file.swmr_mode = True
                recorder = cls(file, final, lock)
                recorder._restart_incomplete()
                return recorder
            except BaseException:
                file.close()
                raise
        except (OSError, RuntimeError, ValueError, SessionError) as error:
            lock.release()
            raise SessionError(f"cannot resume the session {final}: {error}") from error

    def __enter__(self) -> "Recorder":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            self.close()
        except WriteError:
            if kind is None:
                raise

    def append(self, run: str, block: Block) -> None:
        """Add the next block of a run.

        Raises SessionError for a gap, a full or finished run, or a wrong shape.
        """
        row, info = self._row(run), self._infos[run]
        first, used = int(row["samples"]), int(row["blocks"])
        if block.codes.shape[0] != len(self._channels):
            raise SessionError(
                f"{run}: a block of {block.codes.shape[0]} channels, expected {len(self._channels)}"
            )
        if block.start != first:
            raise SessionError(f"{run}: a block starts at sample {block.start}, expected {first}")
        table = self._dataset(f"{run}/blocks")
        if first + block.count > info.planned or used >= table.shape[0]:
            raise SessionError(
                f"{run} is full: {info.planned} samples in {table.shape[0]} blocks were planned"
            )
        for name, codes in zip(self._channels, block.codes, strict=True):
            self._write(f"{run}/data/{name}", first, np.ascontiguousarray(codes, dtype="<i4"))
        entry = (block.start, block.count, block.flags, block.clipped)
        self._write(
            f"{run}/blocks", used, np.array([entry], dtype=block_dtype(len(self._channels)))
        )
        # The status is written last: a kill before leaves the block uncounted, not half valid.
        row["samples"], row["blocks"] = first + block.count, used + 1
        # Settling is normal at the start of a run; every other flag sticks to the run.
        row["flags"] |= np.bitwise_or.reduce(block.flags, initial=0) & ~np.uint16(Flag.NOT_SETTLED)
        self._write_status(run)

    def write_ledger(self, run: str, first_cycle: int, rows: npt.NDArray[np.float64]) -> None:
        """Write ledger rows (cycles, columns), J per cycle, from `first_cycle` on."""
        self._row(run)
        table = self._dataset(f"{run}/truth/ledger")
        if (
            rows.ndim != 2
            or rows.shape[1] != table.shape[1]
            or not 0 <= first_cycle <= table.shape[0] - len(rows)
        ):
            raise SessionError(
                f"{run}: ledger rows of shape {rows.shape} from {first_cycle} on do not fit {table.shape}"
            )
        self._write(f"{run}/truth/ledger", first_cycle, np.ascontiguousarray(rows, dtype="<f8"))

    def finish(self, run: str, scalars: Mapping[str, float], flags: int = 0) -> None:
        """Mark a run complete, with its scalars and further sticky flags.

        Raises WriteError where the file has vanished.
        """
        row, info = self._row(run), self._infos[run]
        if int(row["samples"]) != info.planned:
            raise SessionError(
                f"{run} has {int(row['samples'])} of {info.planned} samples: it is not complete"
            )
        if set(scalars) != set(self._scalar_names):
            raise SessionError(
                f"{run}: scalars {sorted(scalars)}, expected {sorted(self._scalar_names)}"
            )
        if self._scalar_names:
            self._write(
                f"{run}/scalars",
                0,
                np.array([scalars[name] for name in self._scalar_names], dtype="<f8"),
            )
        self._check_there(run)
        row["complete"] = 1
        row["flags"] |= np.uint16(flags)
        self._write_status(run)
        # Handles of a complete run are closed: a session has thousands of datasets.
        self._open = {
            path: rows for path, rows in self._open.items() if not path.startswith(f"{run}/")
        }

    def completed(self) -> set[str]:
        """Return the names of the complete runs."""
        return {name for name, index in self._index.items() if self._rows["complete"][index]}

    def record(self) -> Record:
        """Return the session so far, for reading in this process; valid until the recorder is
        closed.
        """
        return self._record

    def close(self) -> None:
        """Close the file and release the lock; may be called again.

        Raises WriteError where closing fails.
        """
        if self._failed:  # closing would make HDF5 write again, which may crash
            self._lock.release()
            return
        self._open.clear()
        try:
            self._file.close()
        except (OSError, RuntimeError) as error:
            raise WriteError(f"cannot finish writing {self._path}: {error}") from error
        finally:
            self._lock.release()

    def _row(self, run: str) -> Any:
        """Return the status row of a run that is not complete. Raises SessionError."""
        if run not in self._index:
            raise SessionError(f"the session has no run {run!r}")
        row = self._rows[self._index[run]]
        if row["complete"]:
            raise SessionError(f"{run} is complete already")
        return row

    def _restart_incomplete(self) -> None:
        for run, index in self._index.items():
            if not self._rows["complete"][index]:
                self._rows[index] = np.zeros((), dtype=status_dtype)
                self._write_status(run)

    def _write_status(self, run: str) -> None:
        index = self._index[run]
        self._write("session/status", index, self._rows[index : index + 1])

    def _dataset(self, path: str) -> RowWriter:
        if path not in self._open:
            self._open[path] = RowWriter(self._file, path)
        return self._open[path]

    def _write(self, path: str, first: int, rows: npt.NDArray[Any]) -> None:
        """Write rows from `first` on and flush them."""
        try:
            self._dataset(path).write(first, rows)
        except (OSError, RuntimeError) as error:
            self._failed = True
            # HDF5's messages end with buffer addresses and offsets, which tell the user nothing.
            why = str(error).partition(" (file write failed")[0].partition(", buf")[0]
            kept = "what was recorded before is kept, --resume goes on"
            raise WriteError(f"cannot write to {self._path}: {why}; {kept}") from error

    def _check_there(self, run: str) -> None:
        """Raise WriteError where the file was removed or replaced: writing would succeed, and
        nobody would find the data.
        """
        try:
            there = os.path.samestat(os.stat(self._path), os.fstat(self._file.id.get_vfd_handle()))
        except OSError:
            there = False
        if not there:
            raise WriteError(
                f"{self._path} has gone while it was written (at {run}): was its folder removed or renamed?"
            )


def _locked(path: Path) -> WriterLock:
    try:
        return WriterLock(path)
    except (AlreadyLocked, OSError) as error:
        raise SessionError(f"cannot write {path}: {error}") from error
