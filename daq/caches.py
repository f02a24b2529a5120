"""Choose a place for compiled code and fonts when neither the packages nor the home can be written.

numba keeps compiled code beside its module, else in the user's home, and raises at import where it
can do neither; matplotlib warns at each start. So a folder in the temporary directory is chosen
before either is imported. It is passed on by environment variables, which worker processes inherit.
Where the libraries' own choice works, nothing is set.
"""

import atexit
import hashlib
import os
import shutil
import stat
import sys
import tempfile
from contextlib import suppress
from functools import cache
from pathlib import Path

_PACKAGES = [Path(__file__).parents[1] / name for name in ("daq", "analysis", "rig")]


def place_caches() -> None:
    """Set NUMBA_CACHE_DIR and MPLCONFIGDIR where their present values, or the defaults, cannot be
    written.
    """
    caches, settings = _in_home("XDG_CACHE_HOME", ".cache"), _in_home("XDG_CONFIG_HOME", ".config")
    if not _given("NUMBA_CACHE_DIR") and not writable(caches) and not _beside_modules():
        _set("NUMBA_CACHE_DIR", f"numba-{_modules()}")
        if "numba" in sys.modules:  # it has read the variable
            sys.modules["numba"].config.CACHE_DIR = os.environ.get("NUMBA_CACHE_DIR", "")
    if not _given("MPLCONFIGDIR") and not (writable(caches) and writable(settings)):
        _set("MPLCONFIGDIR", "matplotlib")


def writable(folder: Path) -> bool:
    """Return whether a folder can be written, or could be created and then written.

    Creates nothing.
    """
    with suppress(OSError):
        for place in (folder, *folder.parents):
            if os.path.lexists(place):
                return place.is_dir() and os.access(place, os.W_OK | os.X_OK)
    return False


def _given(variable: str) -> bool:
    """Return whether an environment variable names a folder that can be written."""
    value = os.environ.get(variable)
    return bool(value) and writable(Path(str(value)).absolute())


def _in_home(variable: str, name: str) -> Path:
    """Return the user's folder that `variable` names, by default `name` in the home; without a
    home, a path that cannot be written.
    """
    found = Path(os.environ.get(variable) or os.path.expanduser(f"~/{name}"))
    return found if found.is_absolute() else Path(os.devnull) / name


def _beside_modules() -> bool:
    """Return whether numba can keep compiled code beside every module, its first choice."""
    folders = {module.parent for package in _PACKAGES for module in package.rglob("*.py")}
    return all(writable(folder / "__pycache__") for folder in folders)


def _set(variable: str, name: str) -> None:
    folder = _temporary()
    if folder is not None:
        os.environ[variable] = str(folder / name)


@cache
def _temporary() -> Path | None:
    """Return a folder in the temporary directory that only this user can write; None if there can
    be none.

    All processes of a user share it. numba unpickles its cache, so a folder that another user made
    must never be used: a fresh one then serves this process and its children, and is deleted at
    exit.
    """
    user = os.getuid() if hasattr(os, "getuid") else 0
    try:
        shared = Path(tempfile.gettempdir()) / f"particle-damper-rig-{user}"
        with suppress(FileExistsError):
            shared.mkdir(mode=0o700)
        state = shared.lstat()
        private = os.name != "posix" or (
            state.st_uid == user and not state.st_mode & (stat.S_IRWXG | stat.S_IRWXO)
        )
        if stat.S_ISDIR(state.st_mode) and private and writable(shared):
            return shared
        # The name is taken by somebody else's folder, or by a link.
        own = Path(tempfile.mkdtemp(prefix="particle-damper-rig-"))
    except OSError:
        return None
    atexit.register(shutil.rmtree, own, ignore_errors=True)
    return own


def _modules() -> str:
    """Return a hash of the installed modules' paths and times, so that code compiled from another
    version or place is never loaded.
    """
    modules = sorted(path for package in _PACKAGES for path in package.rglob("*.py"))
    text = "\n".join(f"{path} {path.stat().st_mtime_ns}" for path in modules)
    return hashlib.sha256(text.encode("utf-8", "surrogateescape")).hexdigest()[:16]
