"""The package's door, the words for flags and the lock."""

import subprocess
import sys
from pathlib import Path

import pytest

from daq.chain.block import Flag, flag_names
from daq.session.writer_lock import AlreadyLocked, WriterLock


def test_importing_daq_or_its_values_loads_nothing_heavy() -> None:
    code = (
        "import sys, daq, daq.chain.channel, daq.chain.source, daq.chain.block, daq.random_streams\n"
        "import daq.session.plan, daq.chain.clock\n"
        "print([name for name in ('h5py', 'numba', 'scipy') if name in sys.modules])"
    )
    assert (
        subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        ).stdout
        == "[]\n"
    )


def test_there_is_no_such_name() -> None:
    import daq

    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        daq.nothing  # noqa: B018


def test_flags_have_the_words_of_the_session_format() -> None:
    assert flag_names(0xFFFF) == (
        "overload_hi",
        "overload_lo",
        "invalid",
        "overrun",
        "gap",
        "iepe_open",
        "iepe_short",
        "not_settled",
        "sensor_clip",
    )
    assert flag_names(Flag.OVERLOAD_LO | Flag.GAP) == ("overload_lo", "gap")
    assert flag_names(0) == ()


def test_a_lock_excludes_and_is_given_up(tmp_path: Path) -> None:
    lock = WriterLock(tmp_path / "a.h5")
    with pytest.raises(AlreadyLocked, match=r"a\.h5"):
        WriterLock(tmp_path / "a.h5")
    WriterLock(tmp_path / "b.h5").release()
    lock.release()
    lock.release()
    WriterLock(tmp_path / "a.h5").release()
    assert list(tmp_path.iterdir()) == []


def test_a_stale_lock_file_is_no_lock(tmp_path: Path) -> None:
    (tmp_path / "a.h5.lock").write_text("")
    WriterLock(tmp_path / "a.h5").release()
