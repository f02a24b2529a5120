"""The superblock repair against HDF5's own files and the published values of lookup3."""

from pathlib import Path

import h5py
import pytest

from daq.session.hdf5_flags import clear_consistency_flags, lookup3, marked_open

PHRASE = b"Four score and seven years ago"


@pytest.mark.parametrize(
    ("data", "initial", "expected"),
    [
        (b"", 0, 0xDEADBEEF),
        (b"", 0xDEADBEEF, 0xBD5B7DDE),
        (PHRASE, 0, 0x17770551),
        (PHRASE, 1, 0xCD628161),
    ],
)
def test_lookup3_gives_the_values_in_its_authors_driver(
    data: bytes, initial: int, expected: int
) -> None:
    """burtleburtle.net/bob/c/lookup3.c, driver5."""
    assert lookup3(data, initial) == expected


def marked(path: Path) -> bytes:
    """A file as a killed writer leaves it: copied while the writer has it open in single-writer
    mode.
    """
    with h5py.File(path, "w", libver="latest") as file:
        file["x"] = [1, 2, 3]
        file.swmr_mode = True
        file.flush()
        return path.read_bytes()


def test_the_checksum_is_hdf5s_own(tmp_path: Path) -> None:
    marked(tmp_path / "a.h5")
    head = (tmp_path / "a.h5").read_bytes()[:48]
    assert lookup3(head[:44]) == int.from_bytes(head[44:], "little")


def test_a_killed_writers_file_opens_again_after_the_repair(tmp_path: Path) -> None:
    path = tmp_path / "b.h5"
    path.write_bytes(marked(tmp_path / "a.h5"))
    assert marked_open(path)
    with pytest.raises(OSError, match="already open for write"):
        h5py.File(path, "r+", libver="latest")
    assert clear_consistency_flags(path) is True
    assert not marked_open(path)
    with h5py.File(path, "r+", libver="latest") as file:
        assert file["x"][:].tolist() == [1, 2, 3]


def test_a_file_that_was_closed_is_not_touched(tmp_path: Path) -> None:
    marked(tmp_path / "a.h5")
    before = (tmp_path / "a.h5").read_bytes()
    assert clear_consistency_flags(tmp_path / "a.h5") is False
    assert (tmp_path / "a.h5").read_bytes() == before


@pytest.mark.parametrize("place", range(12, 48, 5))
def test_a_damaged_superblock_is_refused_and_left_alone(tmp_path: Path, place: int) -> None:
    content = bytearray(marked(tmp_path / "a.h5"))
    content[place] ^= 0x10
    (tmp_path / "c.h5").write_bytes(content)
    with pytest.raises(ValueError, match="damaged"):
        clear_consistency_flags(tmp_path / "c.h5")
    assert (tmp_path / "c.h5").read_bytes() == bytes(content)


def test_other_files_are_refused(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "old.h5", "w", libver="earliest") as file:
        file["x"] = 1
    (tmp_path / "text.h5").write_text("text")
    for name in ("old.h5", "text.h5"):
        assert not marked_open(tmp_path / name)
        with pytest.raises(ValueError, match="superblock"):
            clear_consistency_flags(tmp_path / name)
