"""Read sessions with an HDF5 that is older than the one that wrote them; `make old-hdf5` runs this.

    python read_with_old_hdf5.py SESSION.h5 ...

Only h5py and numpy are imported, so that any old version of them serves. Every object and attribute
is read.
"""

import sys
from pathlib import Path
from typing import Any

import h5py


def objects_in(path: Path) -> int:
    """Return the number of objects in a file after reading all values and attributes of each."""
    seen: list[str] = []

    def read(name: str, item: Any) -> None:
        dict(item.attrs)
        if isinstance(item, h5py.Dataset):
            item[()]
        seen.append(name)

    with h5py.File(path, "r") as file:
        dict(file.attrs)
        file.visititems(read)
    return len(seen)


if __name__ == "__main__":
    if h5py.version.hdf5_version_tuple >= (2, 0, 0):
        sys.exit(f"HDF5 {h5py.version.hdf5_version} is not older than 2.0")
    for argument in sys.argv[1:]:
        print(
            f"{argument}: {objects_in(Path(argument))} objects read by HDF5 {h5py.version.hdf5_version}"
        )
