"""The HDF5 file of a session: opened, closed, and read so that a damaged or foreign file raises
SessionError.
"""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy.typing as npt

from daq.session.content import read_json
from daq.session.hdf5 import (
    Groups,
    TableReader,
    has,
    is_text,
    members,
    open_for_reading,
    read_attributes,
)
from daq.session.plan import SessionError
from daq.session.time_limit import limited

__all__ = ["SessionFile", "opened"]

KEPT_TABLES = 32  # datasets kept open, enough for a run or two
DAMAGE = (
    OSError,
    RuntimeError,
    KeyError,
    ValueError,
    TypeError,
    IndexError,
    AttributeError,
    MemoryError,
)
"""Exceptions that h5py and the decoders raise on a damaged file."""


def opened(place: Path, patience: float | None) -> Any:
    """Return the HDF5 file at a place, open for reading. Raises SessionError.

    patience : as for `daq.open_session`
    """
    try:
        with limited(patience):
            return open_for_reading(place)
    except DAMAGE as error:
        raise SessionError(f"{place} is not a readable HDF5 file: {error}") from error


class SessionFile:
    """Groups, attributes, texts and tables of a session's file.

    Only hard links are followed, so that a foreign file cannot point the reader at other files.
    """

    def __init__(self, file: Any, path: Path, patience: float | None, made: bool) -> None:
        self._file = file
        self._path = path
        self._patience = patience
        # None for a file that this process made, which needs no checks.
        self._groups = None if made else Groups(file)
        self._owned = file.mode == "r"  # else the recorder owns and closes the file
        self._live = self._owned and file.swmr_mode  # another process may be writing
        self._tables: dict[str, TableReader] = {}  # open and already checked

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; a recorder's own record stays open until the recorder is closed."""
        self._forget()
        if self._owned:
            # nothing was written: nothing is lost
            with suppress(OSError, RuntimeError), limited(self._patience):
                self._file.close()

    def reopen(self) -> None:
        """Open the file again after `close`, in this process or in one forked from it.

        Needed because processes that share a file opened before a fork also share its position and
        its lock.
        """
        self._file = opened(self._path, self._patience)
        self._forget()

    @property
    def live(self) -> bool:
        """Whether another process was writing the file when it was opened, or this process is
        writing it.
        """
        return self._live or not self._owned

    def attributes(self, path: str) -> dict[str, Any]:
        """Return the attributes of a group or dataset of the session."""
        with self.readable():
            return read_attributes(self._file, path)

    def texts(self, path: str) -> tuple[str, ...]:
        """Return the sorted names of the text datasets in a group."""
        with self.readable():
            return tuple(
                name for name in members(self._file, path) if is_text(self._file, f"{path}/{name}")
            )

    def json_or_none(self, path: str) -> Any:
        """Return the JSON value of the text dataset at `path`, None where there is none."""
        with self.readable():
            return read_json(self._file, path) if has(self._file, path) else None

    @contextmanager
    def readable(self) -> Iterator[None]:
        """Raise a SessionError instead of the errors of h5py and the decoders on a foreign or
        damaged file.
        """
        try:
            with limited(self._patience):
                yield
        except DAMAGE as error:
            if isinstance(error, MemoryError):
                raise SessionError(f"{self._path}: out of memory while it was read") from error
            # str() of a KeyError puts its message in quotes.
            why = error.args[0] if isinstance(error, KeyError) and error.args else error
            raise SessionError(f"{self._path} is damaged or not a session: {why}") from error

    def _rows(
        self,
        path: str,
        dtype: npt.DTypeLike,
        shape: tuple[int, ...],
        start: int = 0,
        stop: int | None = None,
    ) -> npt.NDArray[Any]:
        """Return the present rows start..stop of the table with that type and shape."""
        with self.readable():
            return self._table(path, dtype, shape).rows(start, shape[0] if stop is None else stop)

    def _table(self, path: str, dtype: npt.DTypeLike, shape: tuple[int, ...]) -> TableReader:
        """Return a table, opened and checked, or cached; while a writer lives, opened anew, because
        cached chunks are out of date.
        """
        if self._live:
            source = TableReader(self._file, path, dtype, shape, self._groups or Groups(self._file))
            source.refresh()
            return source
        if path not in self._tables:
            if len(self._tables) >= KEPT_TABLES:
                self._forget()
            self._tables[path] = TableReader(self._file, path, dtype, shape, self._groups)
        return self._tables[path]

    def _forget(self) -> None:
        """Let go of all open tables and groups."""
        self._tables.clear()
        if self._groups is not None:
            self._groups = Groups(self._file)
