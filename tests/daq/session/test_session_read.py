"""What a record gives back, and what it says of files that are not intact sessions."""

import dataclasses
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
import session_plans as given
from hypothesis import given as property_of
from hypothesis import settings
from hypothesis import strategies as st

from daq import open_session
from daq.chain.block import Flag
from daq.session.plan import SessionError
from daq.session.writer import Recorder


def write(path: Path) -> Path:
    with Recorder.create(path, given.plan()) as recorder:
        for seed, run in enumerate(("run_0001", "run_0003")):
            values = given.codes(seed=seed)
            recorder.append(run, given.block(0, values[:, :8000], (Flag.OVERLOAD_HI, 0)))
            recorder.append(run, given.block(8000, values[:, 8000:], (0, Flag.INVALID)))
            recorder.write_ledger(run, 0, np.full((4, 2), float(seed)))
        recorder.finish("run_0001", {"force_use": 0.5, "stroke_use": 0.25})
    return path


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("record") / "session.h5")


def test_everything_planned_comes_back(session: Path) -> None:
    plan = given.plan()
    with open_session(session) as record:
        assert record.schema == plan.schema
        assert record.synthetic is True
        assert record.rate == plan.rate
        assert list(record.channels.values()) == list(plan.channels)
        assert record.conditions == {condition["id"]: condition for condition in plan.conditions}
        assert record.protocol_text == plan.protocol_text
        assert record.document("protocol") == plan.protocol
        assert record.document("prediction") == plan.documents["prediction"]
        assert record.document("nothing") is None
        assert [(run.name, run.condition, run.repeat, run.order) for run in record.runs] == [
            (run.name, run.condition, run.repeat, run.order) for run in plan.runs
        ]
        assert record.truth is not None
        assert record.truth.document("instruments") == plan.truth_documents["instruments"]
        columns, ledger = record.truth.ledger("run_0003")
        assert columns == given.COLUMNS
        assert ledger.tolist() == [[1.0, 1.0]] * 4


def test_completeness_is_what_the_status_says(session: Path) -> None:
    with open_session(session) as record:
        assert [(run.samples, run.complete) for run in record.runs] == [
            (20000, True),
            (0, False),
            (20000, False),
        ]
        assert not record.complete
        assert record.scalars("run_0001") == {"force_use": 0.5, "stroke_use": 0.25}
        assert record.scalars("run_0003") == {}


def test_a_signal_is_codes_by_certified_scale_and_sensitivity(session: Path) -> None:
    with open_session(session) as record:
        signal = record.signal("run_0001", "force")
        assert (signal.unit, signal.rate) == ("N", given.RATE)
        expected = given.codes(seed=0)[0] * (10.0 / 2**23) / given.FORCE.sensitivity
        np.testing.assert_allclose(signal.samples, expected, rtol=4e-16)  # two roundings


@settings(max_examples=30, deadline=None)
@property_of(cut=st.tuples(st.integers(0, given.SAMPLES), st.integers(0, given.SAMPLES)))
def test_a_part_is_a_slice_of_the_whole_with_the_flags_of_its_blocks(
    session: Path, cut: tuple[int, int]
) -> None:
    start, stop = sorted(cut)
    with open_session(session) as record:
        np.testing.assert_array_equal(
            record.codes("run_0001", "acceleration", start, stop), given.codes()[1, start:stop]
        )
        touches = stop > start
        assert (
            record.signal("run_0001", "force", start, stop).flags
            == (touches and start < 8000) * Flag.OVERLOAD_HI
        )
        assert (
            record.signal("run_0001", "acceleration", start, stop).flags
            == (touches and stop > 8000) * Flag.INVALID
        )


def test_samples_that_are_not_there_are_refused(session: Path) -> None:
    with open_session(session) as record:
        for run, start, stop in (
            ("run_0002", 0, 1),
            ("run_0001", 0, 20001),
            ("run_0001", -1, 5),
            ("run_0001", 9, 8),
        ):
            with pytest.raises(SessionError, match="valid samples"):
                record.signal(run, "force", start, stop)
        with pytest.raises(SessionError, match="no run"):
            record.signal("run_9", "force")
        with pytest.raises(SessionError, match="no channel"):
            record.signal("run_0001", "temperature")


def test_without_truth_everything_else_is_the_same(session: Path, tmp_path: Path) -> None:
    stripped = write(tmp_path / "stripped.h5")
    with h5py.File(stripped, "r+", libver=("v110", "v110")) as file:
        del file["session/truth"]
        for run in ("run_0001", "run_0002", "run_0003"):
            del file[run]["truth"]
    with open_session(session) as whole, open_session(stripped) as record:
        assert record.truth is None
        assert record.runs == whole.runs
        assert record.channels == whole.channels
        for name in record.channels:
            np.testing.assert_array_equal(
                record.codes("run_0001", name), whole.codes("run_0001", name)
            )
        assert record.scalars("run_0001") == whole.scalars("run_0001")


def test_a_laboratory_session_has_no_truth(tmp_path: Path) -> None:
    with Recorder.create(
        tmp_path / "s.h5", dataclasses.replace(given.plan(), synthetic=False)
    ) as recorder:
        assert recorder.record().truth is None
        assert recorder.record().synthetic is False
    with h5py.File(tmp_path / "s.h5", "r") as file:
        assert "truth" not in file["session"]
        assert "truth" not in file["run_0001"]


def test_a_recorders_record_shows_a_run_as_soon_as_it_is_written(tmp_path: Path) -> None:
    with Recorder.create(tmp_path / "s.h5", given.plan()) as recorder:
        record = recorder.record()
        assert record.run("run_0002").samples == 0
        recorder.append("run_0002", given.block(0, given.codes()))
        np.testing.assert_array_equal(record.codes("run_0002", "force"), given.codes()[0])
        recorder.finish("run_0002", {"force_use": 1.0, "stroke_use": 2.0})
        assert record.run("run_0002").complete
        assert record.scalars("run_0002")["stroke_use"] == 2.0
        record.close()
        recorder.append("run_0001", given.block(0, given.codes()))


def no_status(file: h5py.File) -> None:
    del file["session/status"]


def short_status(file: h5py.File) -> None:
    rows = file["session/status"][:1]
    del file["session/status"]
    file["session/status"] = rows


def no_runs(file: h5py.File) -> None:
    del file["session/runs"]


def broken_json(file: h5py.File) -> None:
    del file["session/runs"]
    file["session/runs"] = b"[{"


def wrong_json(file: h5py.File) -> None:
    del file["session/runs"]
    file["session/runs"] = b'[{"name": "run_0001", "colour": "red"}]'


def external_session(file: h5py.File) -> None:
    del file["session"]
    file["session"] = h5py.ExternalLink(file.filename + ".other", "/session")


def no_schema(file: h5py.File) -> None:
    del file.attrs["schema"]


@pytest.mark.parametrize(
    "damage",
    [no_status, short_status, no_runs, broken_json, wrong_json, external_session, no_schema],
)
def test_damaged_sessions_are_refused_on_opening(
    tmp_path: Path, damage: Callable[[h5py.File], None]
) -> None:
    path = write(tmp_path / "session.h5")
    write(tmp_path / "session.h5.other")
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        damage(file)
    with pytest.raises(SessionError):
        open_session(path)


def external_link(file: h5py.File) -> None:
    del file["run_0001/data/force"]
    file["run_0001/data/force"] = h5py.ExternalLink(
        file.filename + ".other", "/run_0001/data/force"
    )


def soft_link(file: h5py.File) -> None:
    file.move("run_0001/data/force", "elsewhere")
    file["run_0001/data/force"] = h5py.SoftLink("/elsewhere")


def raw_file(file: h5py.File) -> None:
    del file["run_0001/data/force"]
    outside = [(file.filename + ".other", 0, 4 * given.SAMPLES)]
    file["run_0001/data"].create_dataset("force", (given.SAMPLES,), "<i4", external=outside)


def virtual(file: h5py.File) -> None:
    del file["run_0001/data/force"]
    layout = h5py.VirtualLayout((given.SAMPLES,), "<i4")
    layout[:] = h5py.VirtualSource(
        file.filename + ".other", "run_0001/data/force", (given.SAMPLES,)
    )
    file["run_0001/data"].create_virtual_dataset("force", layout)


def text_codes(file: h5py.File) -> None:
    del file["run_0001/data/force"]
    file["run_0001/data/force"] = np.full(given.SAMPLES, b"nonsense")


def group_codes(file: h5py.File) -> None:
    del file["run_0001/data/force"]
    file.create_group("run_0001/data/force")


def few_codes(file: h5py.File) -> None:
    del file["run_0001/data/force"]
    file["run_0001/data/force"] = np.zeros(5, "<i4")


@pytest.mark.parametrize(
    "damage", [external_link, soft_link, raw_file, virtual, text_codes, group_codes, few_codes]
)
def test_samples_that_are_not_plainly_in_the_file_are_refused(
    tmp_path: Path, damage: Callable[[h5py.File], None]
) -> None:
    path = write(tmp_path / "session.h5")
    write(tmp_path / "session.h5.other")
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        damage(file)
    with open_session(path) as record:
        with pytest.raises(SessionError):
            record.signal("run_0001", "force")
        assert len(record.signal("run_0001", "acceleration").samples) == given.SAMPLES


@pytest.mark.parametrize("content", [b"", b"not HDF5 at all", b"\x89HDF\r\n\x1a\n", bytes(100000)])
def test_foreign_files_are_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "foreign.h5"
    path.write_bytes(content)
    with pytest.raises(SessionError, match="not a readable HDF5 file"):
        open_session(path)
    with pytest.raises(SessionError):
        Recorder.resume(path)


def test_a_missing_file_and_a_directory_are_refused(tmp_path: Path) -> None:
    for path in (tmp_path / "nothing.h5", tmp_path):
        with pytest.raises(SessionError, match="no session file"):
            open_session(path)
        with pytest.raises(SessionError, match="no session file"):
            Recorder.resume(path)


@settings(max_examples=60, deadline=None)
@property_of(place=st.floats(0, 1, exclude_max=True), bit=st.one_of(st.none(), st.integers(0, 7)))
def test_a_damaged_file_is_refused_or_read_rightly(
    session: Path, place: float, bit: int | None
) -> None:
    """Cut anywhere, or with one bit turned among the metadata, a file gives a SessionError or the
    true values.
    """
    content = bytearray(session.read_bytes())
    if bit is None:
        del content[int(place * len(content)) :]
    else:
        head = len(content) - 6 * 4 * 2 * 16384  # three runs of two channels of two chunks
        content[int(place * head)] ^= 1 << bit
    damaged = session.parent / "damaged.h5"
    damaged.write_bytes(content)
    try:
        with open_session(damaged) as record:
            assert record.run("run_0002").planned == given.SAMPLES
            assert len(record.codes("run_0001", "force")) in (0, given.SAMPLES)
    except SessionError:
        return
