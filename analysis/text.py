"""Text in reports: counted nouns, and text from strangers made safe for markup."""

import html

from daq.strange_text import visible

__all__ = ["counted", "escape"]


def counted(count: int, noun: str) -> str:
    """Return a number with its noun: "1 run", "8 runs"."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def escape(text: str, keep: str = "\n") -> str:
    """Return text as HTML or XML text: nothing in it is markup, and no character but `keep` is
    hidden.
    """
    return html.escape(visible(text, keep))
