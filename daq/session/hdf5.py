"""The few HDF5 operations that a session needs, on h5py's low-level calls.

A session has thousands of small objects, and the high-level calls take about five times longer. All
space is allocated when a dataset is created, so that no metadata change while samples arrive: a
killed writer can only leave unwritten samples, which the status table does not count.
"""

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt
from h5py import h5a, h5d, h5g, h5l, h5o, h5p, h5s, h5t, h5z  # type: ignore[attr-defined, unused-ignore]

from daq.expansion import ALWAYS, DEFLATE, TIMES, most_unpacked
from daq.session.hdf5_flags import Unmarked, marked_open
from daq.session.writer_lock import is_locked

__all__ = [
    "AttributeValue",
    "Groups",
    "RowWriter",
    "TableReader",
    "array",
    "attributes",
    "dataset",
    "group",
    "has",
    "is_text",
    "members",
    "open_file",
    "open_for_reading",
    "read_attributes",
    "read_text",
    "text",
]

AttributeValue = str | int | float | Sequence[str]
FILTERS = frozenset({h5z.FILTER_DEFLATE, h5z.FILTER_SHUFFLE, h5z.FILTER_FLETCHER32})
# bytes per dataset, four chunks: enough, as records are written and read once, in order
CHUNK_CACHE = 2**18
KEPT_GROUPS = 32  # kept open, enough for some runs
IN_HEADER = 64  # attributes kept in a group's header
FORMAT = ("v110", "v110")
SCALAR = h5s.create(h5s.SCALAR)


def open_file(path: Path, mode: str) -> Any:
    """Open an HDF5 file (h5py.File) for writing, in the format of HDF5 1.10.

    1.10 is the oldest format with the single-writer mode. HDF5 before 2.0 cannot read anything
    newer: it rejects the datatype messages of "latest".
    """
    return h5py.File(path, mode, libver=FORMAT, rdcc_nbytes=CHUNK_CACHE)  # type: ignore[attr-defined, no-untyped-call, unused-ignore]


def open_for_reading(path: Path) -> Any:
    """Open an HDF5 file (h5py.File) for reading, also while a writer has it open or after the
    writer was killed.

    The single-writer mode of reading is used only while a writer lives, because in that mode HDF5
    takes any damage for a write in progress and retries for hours. The mark of a dead writer stays
    in the file, but is hidden from the library.
    """
    swmr = marked_open(path)
    source = Unmarked(path) if swmr and not is_locked(path) else path
    return h5py.File(  # type: ignore[attr-defined, no-untyped-call, unused-ignore]
        source, "r", libver="latest", swmr=swmr and source is path, rdcc_nbytes=CHUNK_CACHE
    )


def group(owner: Any, name: str, values: Mapping[str, AttributeValue]) -> Any:
    """Create a group with attributes in a file or group; return its low-level id."""
    created = h5g.create(owner, name.encode(), gcpl=_group_layout())
    attributes(created, values)
    return created


def attributes(owner: Any, values: Mapping[str, AttributeValue]) -> None:
    """Create attributes: text as fixed-length UTF-8, lists of text as arrays, int64, float64."""
    for name, value in values.items():
        encoded: npt.NDArray[Any]
        if isinstance(value, int):
            encoded, kind = np.array(value, "<i8"), h5t.STD_I64LE
        elif isinstance(value, float):
            encoded, kind = np.array(value, "<f8"), h5t.IEEE_F64LE
        else:
            encoded = np.array(
                value.encode() if isinstance(value, str) else [entry.encode() for entry in value]
            )
            kind = _text_type(encoded.dtype.itemsize)
        space = h5s.create_simple(encoded.shape) if encoded.shape else SCALAR
        h5a.create(owner, name.encode(), kind, space).write(encoded, kind)


def text(owner: Any, name: str, value: str) -> None:
    """Create a scalar UTF-8 dataset of fixed length (attributes end at 64 kB; variable lengths do
    not suit SWMR).
    """
    encoded = np.array(value.encode())
    kind = _text_type(encoded.dtype.itemsize)
    h5d.create(owner, name.encode(), kind, SCALAR).write(h5s.ALL, h5s.ALL, encoded, mtype=kind)


def array(
    owner: Any, name: str, dtype: npt.DTypeLike, shape: tuple[int, ...], chunk: int = 0
) -> Any:
    """Create a fixed-size dataset with allocated space. Tables (chunk = 0) are filled with 0."""
    return h5d.create(
        owner,
        name.encode(),
        _memory_type(np.dtype(dtype)),
        h5s.create_simple(shape),
        _array_layout(chunk),
    )


def has(file: Any, path: str) -> bool:
    """Return whether hard links lead to `path`.

    Soft and external links are not followed: they may point at other files.
    """
    try:
        Groups(file).holder(path)
    except (RuntimeError, KeyError):
        return False
    return True


class Groups:
    """The groups of a file that hard links lead to, opened once each: what they hold is found by its
    name alone, and not by the whole path.
    """

    def __init__(self, file: Any) -> None:
        self._ids = {"": file.id}

    def holder(self, path: str) -> tuple[Any, bytes]:
        """Return the group that holds the object at `path` (low-level id), and the object's name.

        Raises KeyError where hard links do not lead there. HDF5 would follow a soft link in the
        middle of a path, too, so every step is checked.
        """
        above, _, last = path.rpartition("/")
        group, name = self._ids.get(above), last.encode()
        if group is None:
            group = h5g.open(*self.holder(above))
            if len(self._ids) >= KEPT_GROUPS:
                self._ids = {"": self._ids[""]}
            self._ids[above] = group
        if group.links.get_info(name).type != h5l.TYPE_HARD:
            raise KeyError(f"{path} is missing")
        return group, name


def members(file: Any, path: str) -> tuple[str, ...]:
    """Return the sorted names in the group at `path`. Raises KeyError where there is none."""
    if not has(file, path):
        raise KeyError(f"{path} is missing")
    return tuple(sorted(name.decode() for name in h5g.open(file.id, path.encode())))


def is_text(file: Any, path: str) -> bool:
    """Return whether a scalar text dataset is at `path` itself, not reached through a soft or
    external link.
    """
    if not has(file, path) or h5o.get_info(file.id, path.encode()).type != h5o.TYPE_DATASET:
        return False
    found = dataset(file, path)
    kind, space = found.get_type().get_class(), found.get_space().get_simple_extent_type()
    return bool(kind == h5t.STRING and space == h5s.SCALAR)


def dataset(file: Any, path: str) -> Any:
    """Open a dataset (low-level id) whose bytes are in this file, as many as it claims.

    Raises KeyError where there is none; ValueError where its bytes are elsewhere, fewer than
    claimed, or packed by a filter that not every HDF5 reader has (a filter is code, and a foreign
    file must not choose it).
    """
    return _opened(file, path, Groups(file))[0]


def _opened(file: Any, path: str, groups: Groups) -> tuple[Any, Any, tuple[int, ...]]:
    """Return (dataset, its type as a low-level id, its shape), checked as in `dataset`."""
    try:
        group, name = groups.holder(path)
    except (RuntimeError, KeyError):
        raise KeyError(f"{path} is missing") from None
    found = h5d.open(group, name)
    # What has an offset lies in this file as it is, in one piece; asking how takes ten times as long.
    layout = found.get_create_plist() if found.get_offset() is None else None
    filters = [] if layout is None else _filters(layout, path)
    kind, shape = found.get_type(), found.get_space().get_simple_extent_dims()
    item, stored = kind.get_size(), found.get_storage_size()
    size = math.prod(shape) * item
    packing = DEFLATE if filters else 1
    # The file's size first: HDF5 would count the chunks of an absurd dataset one by one.
    if size > packing * file.id.get_filesize() or size > packing * stored:
        raise ValueError(f"{path} claims {size} bytes, more than the file holds of it")
    if layout is not None and filters:
        # a chunk is unpacked as a whole for any read from it
        chunk = math.prod(layout.get_chunk()) * item
        if max(size, chunk) > most_unpacked(stored):
            raise ValueError(
                f"{path} would unpack from {stored} bytes to {max(size, chunk)}; at most {TIMES} times as many are "
                f"unpacked, or {ALWAYS}"
            )
    return found, kind, shape


def _filters(layout: Any, path: str) -> list[int]:
    """Return the filters of a dataset's layout, by number.

    Raises ValueError for data in another file and for other filters than FILTERS.
    """
    if layout.get_layout() == h5d.VIRTUAL or layout.get_external_count():
        raise ValueError(f"{path} keeps its data in another file")
    filters = [layout.get_filter(position)[0] for position in range(layout.get_nfilters())]
    if not FILTERS.issuperset(filters):
        raise ValueError(
            f"{path} is packed by a filter (HDF5 number {max(filters)}); gzip and shuffle are read"
        )
    return filters


class TableReader:
    """A dataset opened for reading.

    Raises KeyError or ValueError where its type or shape is not the given one.

    groups: of the file; None where this process has made the file, so that its datasets need no
    checks.
    """

    def __init__(
        self,
        file: Any,
        path: str,
        dtype: npt.DTypeLike,
        shape: tuple[int, ...],
        groups: Groups | None,
    ) -> None:
        self._dtype, self._shape = np.dtype(dtype), shape
        if groups is None:
            self._source = h5d.open(file.id, path.encode())
            kind, there = self._source.get_type(), self._source.shape
        else:
            self._source, kind, there = _opened(file, path, groups)
        # Comparing HDF5 types first: building numpy's type of a table takes ten times as long.
        same = kind.equal(_memory_type(self._dtype))
        if there != shape or not (same or self._source.dtype == self._dtype):
            raise ValueError(
                f"{path} holds {self._source.dtype} of shape {there}, expected {self._dtype} of {shape}"
            )

    def refresh(self) -> None:
        """Discard cached data, because another process writes."""
        self._source.refresh()

    def rows(self, start: int, stop: int) -> npt.NDArray[Any]:
        """Return rows start..stop. Raises ValueError where there are fewer."""
        rows = np.empty((stop - start, *self._shape[1:]), self._dtype)
        self.read_into(rows, start)
        return rows

    def read_into(self, rows: npt.NDArray[Any], start: int) -> None:
        """Fill contiguous `rows` of the table's type, beginning with row `start`.

        Raises ValueError where there are fewer.
        """
        if not 0 <= start <= start + len(rows) <= self._shape[0]:
            raise ValueError(f"rows {start} to {start + len(rows)} of a table of {self._shape[0]}")
        kind = _memory_type(self._dtype)
        # The common case, a whole table, needs no selection.
        if rows.size and len(rows) == self._shape[0]:
            self._source.read(h5s.ALL, h5s.ALL, rows, kind)
        elif rows.size:
            shape = rows.shape[: len(self._shape)]
            space = self._source.get_space()
            space.select_hyperslab((start, *(0 for _ in self._shape[1:])), shape)
            self._source.read(_whole(shape), space, rows, kind)


class RowWriter:
    """A dataset of a file of this process, opened for writing rows in order.

    No chunk is cached: HDF5 passes samples to the operating system as they come, instead of first
    copying them into a cache and writing that, chunk by chunk, at the flush.
    """

    def __init__(self, file: Any, path: str) -> None:
        self._target = h5d.open(file.id, path.encode(), _uncached())
        self._space = self._target.get_space()
        self._rest = (0,) * (self._target.rank - 1)
        self.shape: tuple[int, ...] = self._target.shape

    def write(self, start: int, rows: npt.NDArray[Any]) -> None:
        """Write rows from `start` on and pass them to the operating system, so that they survive
        this process.
        """
        self._space.select_hyperslab((start, *self._rest), rows.shape)
        self._target.write(_whole(rows.shape), self._space, rows, _memory_type(rows.dtype))
        self._target.flush()


def read_text(source: Any) -> str:
    """Return the value of a scalar text dataset of fixed length. Raises ValueError for others."""
    kind = source.get_type()
    if source.shape != () or kind.get_class() != h5t.STRING or kind.is_variable_str():
        raise ValueError("a dataset that is no text of fixed length")
    value = np.zeros((), dtype=f"S{kind.get_size()}")
    source.read(h5s.ALL, h5s.ALL, value, kind)
    return bytes(value[()]).decode()


def read_attributes(file: Any, path: str) -> dict[str, Any]:
    """Return the attributes of the object at `path` ("" for the root), text decoded.

    Raises KeyError where there is none.
    """
    if path and not has(file, path):
        raise KeyError(f"{path} is missing")
    attributes = file[path or "/"].attrs
    return {name: _decoded(value) for name, value in attributes.items()}


def _decoded(value: Any) -> Any:
    if isinstance(value, bytes):
        return value.decode()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray) and value.dtype.kind in "SO":
        return tuple(_decoded(entry) for entry in value.tolist())
    return value


@lru_cache
def _group_layout() -> Any:
    """Return a group layout with all attributes in the header: the heap used beyond eight would
    cost more than they do.
    """
    layout = h5p.create(h5p.GROUP_CREATE)
    layout.set_attr_phase_change(IN_HEADER, 0)
    return layout


@lru_cache
def _array_layout(chunk: int) -> Any:
    """Return a dataset layout with its space allocated at creation; chunked data are not filled, as
    they are written once.
    """
    layout = h5p.create(h5p.DATASET_CREATE)
    # all space now: no metadata change while samples arrive
    layout.set_alloc_time(h5d.ALLOC_TIME_EARLY)
    layout.set_fill_time(h5d.FILL_TIME_NEVER if chunk else h5d.FILL_TIME_ALLOC)
    if chunk:
        layout.set_chunk((chunk,))
    return layout


@lru_cache
def _uncached() -> Any:
    """Return access properties without a chunk cache."""
    access = h5p.create(h5p.DATASET_ACCESS)
    access.set_chunk_cache(1, 0, 1.0)  # zero bytes
    return access


@lru_cache
def _whole(shape: tuple[int, ...]) -> Any:
    """Return the dataspace of an array in memory."""
    return h5s.create_simple(shape)


@lru_cache
def _memory_type(dtype: np.dtype[Any]) -> Any:
    """Return the HDF5 type of a numpy dtype, cached: building it costs more than writing a row."""
    return h5t.py_create(dtype)


@lru_cache
def _text_type(size: int) -> Any:
    kind = h5t.C_S1.copy()
    kind.set_size(max(1, size))
    kind.set_cset(h5t.CSET_UTF8)
    kind.set_strpad(h5t.STR_NULLPAD)
    return kind
