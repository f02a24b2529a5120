"""Values of the report's classes with what a test needs, and None for all else."""

from dataclasses import MISSING, fields
from typing import Any, TypeVar

T = TypeVar("T")


def bare(cls: type[T], **given: Any) -> T:
    """An instance with the fields that are given."""
    needed = [
        field.name for field in fields(cls) if field.default is field.default_factory is MISSING
    ]
    return cls(**{**dict.fromkeys(needed), **given})
