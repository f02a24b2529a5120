"""The consistency flags that mark an HDF5 file as open for writing, and that a killed writer leaves
set.

HDF5 keeps them in its superblock (file format specification 3.0, section II.A, "File Consistency
Flags": bit 0 open for writing, bit 2 open for single-writer/multiple-reader). While they are set,
the library refuses to open the file for writing. A session's metadata never change after creation,
so that clearing them is safe once no writer is alive. The superblock (versions 2 and 3) ends with a
lookup3 checksum.
"""

import io
import os
from pathlib import Path

from daq.regular_files import open_regular

__all__ = ["Unmarked", "clear_consistency_flags", "lookup3", "marked_open"]

SIGNATURE = b"\x89HDF\r\n\x1a\n"
OPEN_FOR_WRITE, OPEN_FOR_SWMR = 1, 4
VERSION_AT, OFFSET_SIZE_AT, FLAGS_AT, ADDRESSES_AT = 8, 9, 11, 12
LONGEST_SUPERBLOCK = ADDRESSES_AT + 4 * 255 + 4  # bytes, checksum included


def lookup3(data: bytes, initial: int = 0) -> int:
    """Return the lookup3 hash (hashlittle; Bob Jenkins, burtleburtle.net/bob/c/lookup3.c) of
    `data`, HDF5's metadata checksum.
    """
    mask = 0xFFFFFFFF
    a = b = c = (0xDEADBEEF + len(data) + initial) & mask
    if not data:
        return c

    def rotated(x: int, k: int) -> int:
        return ((x << k) | (x >> (32 - k))) & mask

    words = [int.from_bytes(data[i : i + 4], "little") for i in range(0, len(data), 4)]
    # zeros do not change the sums: as in lookup3.c for the last, partial block
    words += [0] * (-len(words) % 3)
    # mix() of lookup3.c for all words but the last three, then final().
    for i in range(0, len(words) - 3, 3):
        a, b, c = (a + words[i]) & mask, (b + words[i + 1]) & mask, (c + words[i + 2]) & mask
        a, c = ((a - c) & mask) ^ rotated(c, 4), (c + b) & mask
        b, a = ((b - a) & mask) ^ rotated(a, 6), (a + c) & mask
        c, b = ((c - b) & mask) ^ rotated(b, 8), (b + a) & mask
        a, c = ((a - c) & mask) ^ rotated(c, 16), (c + b) & mask
        b, a = ((b - a) & mask) ^ rotated(a, 19), (a + c) & mask
        c, b = ((c - b) & mask) ^ rotated(b, 4), (b + a) & mask
    a, b, c = (a + words[-3]) & mask, (b + words[-2]) & mask, (c + words[-1]) & mask
    c = ((c ^ b) - rotated(b, 14)) & mask
    a = ((a ^ c) - rotated(c, 11)) & mask
    b = ((b ^ a) - rotated(a, 25)) & mask
    c = ((c ^ b) - rotated(b, 16)) & mask
    a = ((a ^ c) - rotated(c, 4)) & mask
    b = ((b ^ a) - rotated(a, 14)) & mask
    return ((c ^ b) - rotated(b, 24)) & mask


def marked_open(path: Path) -> bool:
    """Return whether the file is marked as open for writing; False also for files without such
    flags. Raises OSError.
    """
    with open_regular(path) as file:
        head = file.read(ADDRESSES_AT)
    return _has_flags(head) and bool(head[FLAGS_AT] & (OPEN_FOR_WRITE | OPEN_FOR_SWMR))


def clear_consistency_flags(path: Path) -> bool:
    """Clear the open-for-writing flags of the HDF5 file at `path`; return whether any were set.

    Call it only when no process has the file open for writing. Raises ValueError where the file
    does not begin with an intact version 2 or 3 superblock, OSError where it cannot be read or
    written.
    """
    with path.open("r+b") as file:
        old = file.read(LONGEST_SUPERBLOCK)
        new = _cleared(old, path)
        if new == old:
            return False
        file.seek(0)
        file.write(new)
        file.flush()
        os.fsync(file.fileno())
        return True


class Unmarked(io.FileIO):
    """A read-only view of an HDF5 file in which the flags of a dead writer are cleared; the file
    itself keeps them.

    Raises the errors of clear_consistency_flags.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, "r")
        try:
            self._head = _cleared(super().read(LONGEST_SUPERBLOCK) or b"", path)
        except ValueError:
            self.close()
            raise

    def readinto(self, buffer: memoryview) -> int:  # type: ignore[override]
        """Read bytes from the current position, those of the superblock with the flags cleared."""
        start = self.tell()
        count = super().readinto(buffer) or 0
        if start < len(self._head):
            # The head replaces the bytes of the file that it covers.
            part = self._head[start : start + count]
            memoryview(buffer).cast("B")[: len(part)] = part
        return count


def _cleared(head: bytes, path: Path) -> bytes:
    """Return the first bytes of a file with the flags cleared and the superblock's checksum
    recomputed.
    """
    if not _has_flags(head[:ADDRESSES_AT]):
        raise ValueError(f"{path} does not begin with an HDF5 superblock of version 2 or 3")
    end = ADDRESSES_AT + 4 * head[OFFSET_SIZE_AT]
    body = head[:end]
    if lookup3(body) != int.from_bytes(head[end : end + 4], "little"):
        raise ValueError(f"the HDF5 superblock of {path} is damaged (its checksum is wrong)")
    # Other flags are kept: only the marks of writers are cleared.
    flags = body[FLAGS_AT] & ~(OPEN_FOR_WRITE | OPEN_FOR_SWMR)
    body = body[:FLAGS_AT] + bytes([flags]) + body[FLAGS_AT + 1 :]
    return body + lookup3(body).to_bytes(4, "little") + head[end + 4 :]


def _has_flags(head: bytes) -> bool:
    return len(head) == ADDRESSES_AT and head[:8] == SIGNATURE and head[VERSION_AT] in (2, 3)
