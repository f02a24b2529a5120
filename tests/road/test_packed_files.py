"""Files that unpack to far more than a record does are refused, and long records are written without
being held in memory.
"""

import sys
import weakref
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io

import daq.expansion
from daq.formats.reading import read_columns
from daq.formats.uff58 import write_uff58
from daq.formats.wave import FormatError, Wave
from daq.formats.writing import write_csv

ZEROS = np.zeros(2**18)


def zip_bomb(path: Path) -> None:
    np.savez_compressed(path, channels=np.array('[{"name": "F", "fs": 1000.0}]'), data_0=ZEROS)


def mat_bomb(path: Path) -> None:
    scipy.io.savemat(path, {"F": ZEROS}, do_compression=True)


def h5_bomb(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file.create_dataset("F", data=ZEROS, compression="gzip", chunks=True)


def mat73_bomb(path: Path) -> None:
    with h5py.File(path, "w", userblock_size=512) as file:
        file.create_dataset("F", data=ZEROS, compression="gzip", chunks=True)
    with path.open("r+b") as head:
        head.write(b"MATLAB 7.3 MAT-file")


def chunk_bomb(path: Path) -> None:
    """One value, in a chunk of two million."""
    with h5py.File(path, "w") as file:
        file.create_dataset(
            "F", data=ZEROS[:1], maxshape=(None,), compression="gzip", chunks=(2**18,)
        )


BOMBS = {"npz": ("sep005", zip_bomb), "mat": ("mat", mat_bomb), "h5": ("hdf5", h5_bomb), "73.mat": ("mat", mat73_bomb),
         "chunk.h5": ("hdf5", chunk_bomb)}  # fmt: skip


@pytest.mark.parametrize("name", BOMBS)
def test_a_file_that_unpacks_to_far_more_than_a_record_does_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """2 MiB of zeros in some kB, the floor lowered below them; at the floor as it is they are
    welcome.
    """
    kind, make = BOMBS[name]
    path = tmp_path / f"x.{name}"
    make(path)
    assert not read_columns(path, kind, ["F"])["F"].samples.any()
    matlab, column = (sys.modules[f"daq.formats.{name}"] for name in ("matlab", "column"))
    for module in (daq.expansion, matlab, column):
        monkeypatch.setattr(module, "ALWAYS", 2**18)
    with pytest.raises(FormatError, match="would unpack from"):
        read_columns(path, kind, ["F"])


@pytest.mark.parametrize("name", ["npz", "mat", "h5"])
def test_a_measurement_packs_less_than_the_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """Sixteen bits of a sine with two of noise pack to a third or so: welcome at any size, so
    without a floor too.
    """
    noise = np.random.default_rng(1).integers(0, 4, ZEROS.size)
    record = np.round(20000 * np.sin(0.01 * np.arange(ZEROS.size))) + noise
    monkeypatch.setattr(sys.modules[__name__], "ZEROS", record)
    matlab, column = (sys.modules[f"daq.formats.{name}"] for name in ("matlab", "column"))
    for module in (daq.expansion, matlab, column):
        monkeypatch.setattr(module, "ALWAYS", 0)
    kind, make = BOMBS[name]
    make(tmp_path / f"x.{name}")
    assert np.array_equal(read_columns(tmp_path / f"x.{name}", kind, ["F"])["F"].samples, record)


def test_a_packed_csv_is_no_csv(tmp_path: Path) -> None:
    import gzip

    (tmp_path / "x.csv.gz").write_bytes(gzip.compress(b"F,a\n" + b"0,0\n" * 2**18))
    with pytest.raises(FormatError):
        read_columns(tmp_path / "x.csv.gz", "csv", ["F"])


class Streamed:
    """Chunks of which two at most are there when the next is asked for."""

    size = 40 * 1024

    def chunks(self, length: int = 1024) -> Iterator[np.ndarray]:
        given: list[weakref.ref[np.ndarray]] = []
        length = min(length, 1024)
        for start in range(0, self.size, length):
            chunk = start + np.arange(float(length))
            given.append(weakref.ref(chunk))
            yield chunk
            del chunk
            assert (
                sum(one() is not None for one in given) <= 2
            )  # one is written, one is in zip's own hands

    def samples(self) -> np.ndarray:
        raise AssertionError("all samples at once")


def test_csv_and_uff58_are_written_bit_by_bit(tmp_path: Path) -> None:
    waves = [
        Wave("F", "force", "N", Streamed(), 1000.0),
        Wave("a", "acceleration", "m/s^2", Streamed(), 1000.0),
    ]
    write_csv(tmp_path / "x.csv", waves)
    assert np.array_equal(
        np.loadtxt(tmp_path / "x.csv", skiprows=1, delimiter=",")[:, 1], np.arange(Streamed.size)
    )
    write_uff58(tmp_path / "x.uff", "x", waves)
