"""Numbers in sentences."""

__all__ = ["counted"]


def counted(count: int, noun: str) -> str:
    """ "1 run", "8 runs"."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
