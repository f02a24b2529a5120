"""Every number of the catalog with its origin in one table, for `rig catalog`."""

from collections.abc import Iterator
from typing import NamedTuple

from rig.catalog.entries_by_name import KINDS, shelf
from rig.catalog.rig_file import load_rig, rig_names


class Row(NamedTuple):
    """A number of the catalog in a listing."""

    kind: str
    name: str
    field: str
    value: float | tuple[float, ...] | None
    unit: str
    status: str
    source: str


def listing() -> tuple[Row, ...]:
    """Return every number of the catalog with its origin, kind by kind in the order of the files;
    the rigs' are last.
    """
    return (*_shelved(), *_rigs())


def _rigs() -> Iterator[Row]:
    for name in rig_names():
        for value in load_rig(name).values:
            yield Row("rig", name, value.path, value.value, value.unit, value.status, value.source)


def _shelved() -> tuple[Row, ...]:
    return tuple(
        Row(kind, name, value.path, value.value, value.unit, value.status, value.source)
        for kind in KINDS
        for name, entry in shelf(kind).items()
        for value in entry.values
    )
