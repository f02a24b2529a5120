"""The shipped protocols by name, so that `rig run fill_rate` works outside a checkout too."""

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
    """Return the names of all shipped protocols; one in a folder reads `gallery/skew`."""
    place = folder()
    return sorted(
        path.relative_to(place).with_suffix("").as_posix() for path in place.rglob("*.yaml")
    )


def protocol_path(source: str | Path) -> Path:
    """Return the path of a protocol given by path or by shipped name; an existing file comes
    first.
    """
    name = str(source)
    if not os.path.isfile(name) and name in names():
        return folder() / f"{name}.yaml"
    return Path(source)


def hint(name: str) -> str:
    """Return the hint for a file that does not exist, "" for none.

    It names the shipped protocol that had this name before, or the one of the nearest name.
    """
    bare = (
        name.replace("\\", "/")
        .removeprefix("protocols/")
        .removesuffix(".yaml")
        .removesuffix(".yml")
    )
    stem = bare.rpartition("/")[2]
    for former in (bare, stem):
        renamed = new_name(former, names(), FORMER_PROTOCOLS)
        if renamed:
            return renamed
    return nearest(bare, names())
