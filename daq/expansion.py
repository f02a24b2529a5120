"""How much larger than itself a packed file of a stranger may become, checked before anything is unpacked."""

__all__ = ["ALWAYS", "DEFLATE", "TIMES", "most_unpacked"]

ALWAYS = 2**28
"""Bytes that any file may unpack to: an idle channel packs to nearly nothing."""

TIMES = 100
"""Times its packed size that it may unpack to beyond that: records of a measurement pack to a half or a tenth."""

DEFLATE = 1032
"""Times by which zlib's method makes zeros smaller, at most."""


def most_unpacked(packed: int) -> int:
    """Return the bytes to which `packed` ones may unpack."""
    return max(ALWAYS, TIMES * packed)
