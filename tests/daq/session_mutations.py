"""Mutated session files: bytes changed anywhere, metadata changed under a right checksum, odd
content, odd objects.
"""

import json
import random
import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from daq.session.hdf5_flags import lookup3

SIGNATURES = (
    b"OHDR",
    b"OCHK",
    b"FRHP",
    b"FHDB",
    b"FHIB",
    b"BTHD",
    b"BTIN",
    b"BTLF",
    b"FAHD",
    b"FADB",
)
ODD: tuple[Any, ...] = (
    None,
    True,
    -1,
    0,
    1e308,
    -1e308,
    1e-320,
    2**70,
    "",
    "x",
    [],
    {},
    [1, 2],
    {"a": 1},
    "run_0001",
    "ä" * 5000,
    3.5,
    [None] * 3,
    "nan",
    "[bold]",
    "\x1b[2J",
)
ODD_TEXTS = ("{", "[1,", "NaN", '{"a": Infinity}', "[" * 100000, '"\\ud800"', "1e999", "")
ODD_ATTRIBUTES: tuple[Any, ...] = (
    np.nan,
    np.inf,
    -1.0,
    0.0,
    0,
    -1,
    "x",
    "",
    np.zeros(3),
    np.array([b"a", b"b"]),
    2**62,
    h5py.Empty("f"),
    np.zeros((2, 2)),
    b"\xff\xfe",
)


@cache
def checksummed(path: Path) -> dict[int, int]:
    """Places and lengths of the HDF5 structures that end with a checksum."""
    data = path.read_bytes()
    starts = [0]
    for signature in SIGNATURES:
        at = data.find(signature)
        while at >= 0:
            starts.append(at)
            at = data.find(signature, at + 1)
    return {start: length for start in starts if (length := _length(data, start))}


def _length(data: bytes, start: int) -> int:
    for n in range(8, 1200):
        if data[start + n : start + n + 4] == lookup3(data[start : start + n]).to_bytes(
            4, "little"
        ):
            return n
    return 0


def mutated(source: Path, target: Path, seed: int) -> None:
    """Write the mutation of a session that belongs to a seed."""
    rng = random.Random(seed)
    rng.choice(
        (
            flipped,
            cut,
            spliced,
            structure,
            structure,
            document,
            document,
            document,
            table,
            attribute,
            thing,
        )
    )(source, target, rng)


def _bytes(
    change: Callable[[bytearray, random.Random], None],
) -> Callable[[Path, Path, random.Random], None]:
    def write(source: Path, target: Path, rng: random.Random) -> None:
        data = bytearray(source.read_bytes())
        change(data, rng)
        target.write_bytes(data)

    return write


@_bytes
def flipped(data: bytearray, rng: random.Random) -> None:
    for _ in range(rng.choice((1, 2, 8, 64))):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


@_bytes
def cut(data: bytearray, rng: random.Random) -> None:
    at, size = rng.randrange(len(data)), rng.choice((1, 8, 1000))
    match rng.randrange(4):
        case 0:
            del data[at:]
        case 1:
            del data[at : at + size]
        case 2:
            data[at:at] = rng.randbytes(size)
        case _:
            data[at : at + size] = bytes(len(data[at : at + size]))


@_bytes
def spliced(data: bytearray, rng: random.Random) -> None:
    size = rng.choice((4, 64, 4096))
    a, b = (rng.randrange(len(data) - size) for _ in range(2))
    data[a : a + size] = data[b : b + size]


def structure(source: Path, target: Path, rng: random.Random) -> None:
    """Bytes of HDF5's own structures changed, checksum made right: what the checksums do not
    protect from.
    """
    data = bytearray(source.read_bytes())
    start, length = rng.choice(sorted(checksummed(source).items()))
    for _ in range(rng.choice((1, 1, 2, 5))):
        at = start + 4 + rng.randrange(length - 4)
        data[at] = rng.choice(
            (0, 1, 0xFF, 0x7F, 0x80, rng.randrange(256), data[at] ^ (1 << rng.randrange(8)))
        )
    data[start + length : start + length + 4] = lookup3(
        bytes(data[start : start + length])
    ).to_bytes(4, "little")
    target.write_bytes(data)


def _content(
    change: Callable[[h5py.File, random.Random], None],
) -> Callable[[Path, Path, random.Random], None]:
    def write(source: Path, target: Path, rng: random.Random) -> None:
        shutil.copy(source, target)
        with h5py.File(target, "r+", libver=("v110", "v110")) as file:
            change(file, rng)

    return write


@_content
def document(file: h5py.File, rng: random.Random) -> None:
    session = file["session"]
    own = [
        name
        for name in session
        if isinstance(session[name], h5py.Dataset) and session[name].dtype.kind == "S"
    ]
    name = rng.choice(
        [
            *(name for name in own if name != "protocol_text"),
            *(f"truth/{n}" for n in session["truth"]),
        ]
    )
    value = json.loads(session[name][()])
    for _ in range(rng.choice((1, 1, 3))):
        value = _odd_somewhere(value, rng)
    text = json.dumps(value) if rng.random() < 0.9 else rng.choice(ODD_TEXTS)
    del session[name]
    session.create_dataset(name, data=np.array(text.encode()))


def _odd_somewhere(value: Any, rng: random.Random) -> Any:
    paths = list(_paths(value))
    path = rng.choice(paths)
    if not path:
        return rng.choice(ODD)
    owner = value
    for key in path[:-1]:
        owner = owner[key]
    if rng.random() < 0.25:
        del owner[path[-1]]
    else:
        owner[path[-1]] = rng.choice(ODD)
    return value


def _paths(value: Any, before: tuple[Any, ...] = ()) -> Any:
    yield before
    entries = (
        value.items()
        if isinstance(value, dict)
        else enumerate(value)
        if isinstance(value, list)
        else ()
    )
    for key, entry in entries:
        yield from _paths(entry, (*before, key))


@_content
def table(file: h5py.File, rng: random.Random) -> None:
    runs = [name for name in file if name != "session"]
    path = rng.choice(("session/status", *(f"{run}/blocks" for run in runs)))
    rows = file[path][()]
    name = rng.choice(rows.dtype.names)
    bits = 8 * rows.dtype[name].base.itemsize
    rows[name][rng.randrange(len(rows))] = rng.choice((0, 1, 7, 255, 2**31, 2**63, 2**64 - 1)) & (
        2**bits - 1
    )
    file[path][...] = rows


@_content
def attribute(file: h5py.File, rng: random.Random) -> None:
    runs = [name for name in file if name != "session"]
    parts = ("", "/data", "/data/force", "/truth/ledger", "/scalars")
    owners = ["/", "session", *(f"session/channels/{name}" for name in file["session/channels"])]
    owner = file[rng.choice([*owners, *(run + part for run in runs for part in parts)])]
    name = rng.choice(list(owner.attrs))
    del owner.attrs[name]
    if rng.random() > 0.2:
        owner.attrs[name] = rng.choice(ODD_ATTRIBUTES)


@_content
def thing(file: h5py.File, rng: random.Random) -> None:
    """An object that is gone, of another kind, elsewhere, or absurdly large."""
    name = rng.choice(
        (
            "session",
            "session/channels",
            "session/channels/force",
            "session/status",
            "session/conditions",
            "session/runs",
            "session/scalars",
            "session/prediction",
            "session/truth",
            "session/truth/instruments",
            "run_0001",
            "run_0001/blocks",
            "run_0001/data",
            "run_0001/data/force",
            "run_0001/scalars",
            "run_0001/truth/ledger",
        )
    )
    codes = file["run_0001/data/force"][()]
    del file[name]
    match rng.randrange(10):
        case 0:
            file.create_group(name)
        case 1:
            file.create_dataset(name, data=np.zeros((3, 3)))
        case 2:
            file.create_dataset(name, data=h5py.Empty("i4"))
        case 3:
            file.create_dataset(name, data="text", dtype=h5py.string_dtype())
        case 4:
            file.create_dataset(name, shape=(2**33, 2**20), dtype="f8", chunks=(1, 1024))
        case 5:
            file[name] = rng.choice((h5py.SoftLink("/session"), h5py.SoftLink(f"/{name}")))
        case 6:
            file[name] = h5py.ExternalLink("elsewhere.h5", f"/{name}")
        case 7:
            file.create_dataset(name, data=codes, compression=rng.choice(("lzf", "gzip")))
        case 8:
            layout = h5py.VirtualLayout(shape=codes.shape, dtype="i4")
            layout[:] = h5py.VirtualSource("elsewhere.h5", "codes", shape=codes.shape)
            file.create_virtual_dataset(name, layout)
