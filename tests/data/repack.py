"""Write a session anew, object by object: packed, and in the file format that sessions have today.

    python tests/data/repack.py OLD.h5 NEW.h5

Every dataset, attribute and type is made afresh, as the newest HDF5 keeps the version of what it
copies; values stay.
"""

import sys
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from daq.session.hdf5 import open_file


def repack(old: Path, new: Path) -> None:
    with h5py.File(old, "r") as source, open_file(new, "w") as target:
        _group(source, target)


def _group(source: Any, target: Any) -> None:
    _attributes(source, target)
    for name, item in source.items():
        if isinstance(item, h5py.Group):
            _group(item, target.create_group(name))
        else:
            value = _typed(item[()])
            packing = (
                {"compression": "gzip", "shuffle": True, "chunks": item.chunks}
                if item.chunks
                else {}
            )
            _attributes(item, target.create_dataset(name, data=value, **packing))


def _attributes(source: Any, target: Any) -> None:
    for name, value in source.attrs.items():
        target.attrs.create(name, _typed(value))


def _typed(value: Any) -> np.ndarray[Any, Any]:
    found = np.asarray(value)
    return (
        found.astype(h5py.string_dtype("utf-8", found.dtype.itemsize))
        if found.dtype.kind == "S"
        else found
    )


if __name__ == "__main__":
    repack(Path(sys.argv[1]), Path(sys.argv[2]))
