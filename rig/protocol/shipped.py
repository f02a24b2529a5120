"""The shipped protocols by name: `rig run fill_rate` works outside a checkout too."""

import os
from pathlib import Path

from daq.documents.notes import nearest, new_name
from rig.documents.former_names import FORMER_PROTOCOLS

_PACKAGE = Path(__file__).parents[1]


def folder() -> Path:
    """Return the folder of the shipped protocols: inside the package where it is installed, at the
    top of a checkout otherwise (setup.py)."""
    installed = _PACKAGE / "protocols"
    return installed if installed.is_dir() else _PACKAGE.parent / "protocols"


def names() -> list[str]:
    """Return the names of all shipped protocols, `gallery/skew` for one in a folder."""
    place = folder()
    return sorted(
        path.relative_to(place).with_suffix("").as_posix() for path in place.rglob("*.yaml")
    )


def protocol_path(source: str | Path) -> Path:
    """Return the file that a protocol is asked for by: a file's own path comes first, then a
    shipped name.
    """
    name = str(source)
    if not os.path.isfile(name) and name in names():
        return folder() / f"{name}.yaml"
    return Path(source)


def hint(name: str) -> str:
    """Return the hint for a file that is not there: the shipped protocol of this or the nearest
    name, or "".
    """
    bare = (
        name.replace("\\", "/")
        .removeprefix("protocols/")
        .removesuffix(".yaml")
        .removesuffix(".yml")
    )
    stem = bare.rpartition("/")[2]
    now = (new_name(one, names(), FORMER_PROTOCOLS) for one in (bare, stem))
    return next(filter(None, now), "") or nearest(bare, names())
