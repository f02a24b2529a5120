"""What the annotation of a document's field may hold beside its unit and range."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class OneOf:
    """The words that a text field may hold."""

    words: tuple[str, ...]
