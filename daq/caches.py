"""Where compiled code and fonts are kept when neither the installed packages nor the home can be written.

numba keeps compiled code beside its module, else in the user's home, and raises at import where it can do neither;
matplotlib warns at each start. So a place in the temporary folder is chosen before either is imported, by environment
variables, which worker processes inherit. Where their own choice works, nothing is set.
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
    """Set NUMBA_CACHE_DIR and MPLCONFIGDIR where what they say, or stand for, cannot be written."""
    caches, settings = _in_home("XDG_CACHE_HOME", ".cache"), _in_home("XDG_CONFIG_HOME", ".config")
    if not _given("NUMBA_CACHE_DIR") and not writable(caches) and not _beside_modules():
        _set("NUMBA_CACHE_DIR", f"numba-{_modules()}")
        if "numba" in sys.modules:  # it has read the variable
            sys.modules["numba"].config.CACHE_DIR = os.environ.get("NUMBA_CACHE_DIR", "")
    if not _given("MPLCONFIGDIR") and not (writable(caches) and writable(settings)):
        _set("MPLCONFIGDIR", "matplotlib")


def writable(folder: Path) -> bool:
    """Return whether a folder can be written, or could be made and then written; makes nothing."""
    with suppress(OSError):
        for place in (folder, *folder.parents):
            if os.path.lexists(place):
                return place.is_dir() and os.access(place, os.W_OK | os.X_OK)
    return False


def _given(variable: str) -> bool:
    value = os.environ.get(variable)
    return bool(value) and writable(Path(str(value)).absolute())


def _in_home(variable: str, name: str) -> Path:
    """Return a folder of the user's; where there is no home, one that cannot be written."""
    found = Path(os.environ.get(variable) or os.path.expanduser(f"~/{name}"))
    return found if found.is_absolute() else Path(os.devnull) / name


def _beside_modules() -> bool:
    folders = {module.parent for package in _PACKAGES for module in package.rglob("*.py")}
    return all(writable(folder / "__pycache__") for folder in folders)


def _set(variable: str, name: str) -> None:
    folder = _temporary()
    if folder is not None:
        os.environ[variable] = str(folder / name)


@cache
def _temporary() -> Path | None:
    """Return a folder of this user alone in the temporary folder, the same for all processes; None where none can be.

    numba unpickles what it finds there, so that what another user has made must never be taken: then a fresh folder
    serves this process and its children, and is deleted in the end.
    """
    user = os.getuid() if hasattr(os, "getuid") else 0
    try:
        shared = Path(tempfile.gettempdir()) / f"particle-damper-rig-{user}"
        with suppress(FileExistsError):
            shared.mkdir(mode=0o700)
        state = shared.lstat()
        private = os.name != "posix" or (state.st_uid == user and not state.st_mode & (stat.S_IRWXG | stat.S_IRWXO))
        if stat.S_ISDIR(state.st_mode) and private and writable(shared):
            return shared
        own = Path(tempfile.mkdtemp(prefix="particle-damper-rig-"))
    except OSError:
        return None
    atexit.register(shutil.rmtree, own, ignore_errors=True)
    return own


def _modules() -> str:
    """Return a word for the installed modules: compiled code of another version or place is never met."""
    modules = sorted(path for package in _PACKAGES for path in package.rglob("*.py"))
    text = "\n".join(f"{path} {path.stat().st_mtime_ns}" for path in modules)
    return hashlib.sha256(text.encode("utf-8", "surrogateescape")).hexdigest()[:16]
