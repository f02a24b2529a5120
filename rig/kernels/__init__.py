"""Compiled loops: arithmetic only, no physical decisions.

numba stores the compiled code of a function beside its module and checks that module alone to
decide whether the code is current: a change in a function called from another module would go
unnoticed. Therefore compiled code older than the youngest module of this package is deleted when
the package is imported.
"""

from contextlib import suppress
from pathlib import Path


def drop_stale(package: Path, *used: Path) -> None:
    """Delete numba index files of a package that are older than any module of it or of the `used`
    packages.
    """
    youngest = max(
        module.stat().st_mtime_ns for folder in (package, *used) for module in folder.rglob("*.py")
    )
    for index in package.rglob("__pycache__/*.nbi"):
        # Another process deleted it first, or this one has no permission while another may.
        with suppress(OSError):  # another process did it, or may and this one may not
            if index.stat().st_mtime_ns < youngest:
                index.unlink()


drop_stale(Path(__file__).parent)
