"""Limits on the unpacked size of a compressed file from a stranger, checked before anything is
unpacked.
"""

__all__ = ["ALWAYS", "DEFLATE", "TIMES", "most_unpacked"]

ALWAYS = 2**28
"""Bytes to which any file may unpack: an idle channel compresses to nearly nothing."""

TIMES = 100
"""Largest ratio of unpacked to packed size beyond that; measured records compress to a half or a
tenth.
"""

DEFLATE = 1032
"""Largest compression ratio of zlib's method, reached with zeros."""


def most_unpacked(packed: int) -> int:
    """Return the bytes to which `packed` bytes may unpack."""
    return max(ALWAYS, TIMES * packed)
