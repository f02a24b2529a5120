"""Messages between a process and the LAMMPS that it started: named arrays, each with its length."""

import io
from collections.abc import Mapping
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

Message = dict[str, NDArray[Any]]

_LENGTH = 8
"""Bytes of the length that precedes a message."""


def packed(message: Mapping[str, Any]) -> bytes:
    """Return named arrays, numbers and texts as bytes."""
    buffer = io.BytesIO()
    arrays: dict[str, Any] = {name: np.asarray(value) for name, value in message.items()}
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def unpacked(data: bytes) -> Message:
    """Return the named arrays of a message."""
    with np.load(io.BytesIO(data), allow_pickle=False) as found:
        return {name: found[name] for name in found.files}


def send(stream: IO[bytes], data: bytes) -> None:
    """Write the bytes of a message. Raises OSError where nobody reads any more."""
    stream.write(len(data).to_bytes(_LENGTH, "little"))
    stream.write(data)
    stream.flush()


def receive(stream: IO[bytes]) -> bytes:
    """Return the bytes of the next message. Raises EOFError where none comes any more."""
    return _exactly(stream, int.from_bytes(_exactly(stream, _LENGTH), "little"))


def _exactly(stream: IO[bytes], size: int) -> bytes:
    parts, left = [], size
    while left:
        part = stream.read(left)
        if not part:
            raise EOFError
        parts.append(part)
        left -= len(part)
    return b"".join(parts)
