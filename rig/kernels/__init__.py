"""Compiled loops: arithmetic only, no physical decision.

numba keeps the compiled code of a function beside its module and looks at that module alone to see whether it is still
true: a change in a function that it calls from another module would go unseen. So whatever was compiled before the
youngest module of this package is thrown away when the package is imported.
"""

from contextlib import suppress
from pathlib import Path


def drop_stale(package: Path, *used: Path) -> None:
    """Delete numba's indexes of a package's modules that are older than one of its or of the `used` packages'."""
    youngest = max(module.stat().st_mtime_ns for folder in (package, *used) for module in folder.rglob("*.py"))
    for index in package.rglob("__pycache__/*.nbi"):
        with suppress(OSError):  # another process did it, or may and this one may not
            if index.stat().st_mtime_ns < youngest:
                index.unlink()


drop_stale(Path(__file__).parent)
