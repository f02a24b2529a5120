"""What a recorder writes, read back by plain h5py: the independent reader."""

import dataclasses
import itertools
import json
from pathlib import Path

import h5py
import numpy as np
import pytest
import session_plans as given

from daq.chain.block import Flag
from daq.session.plan import SessionError
from daq.session.writer import Recorder


def fill(
    recorder: Recorder, run: str, values: np.ndarray, cuts: tuple[int, ...] = (5000, 12000)
) -> None:
    edges = (0, *cuts, values.shape[1])
    for start, stop in itertools.pairwise(edges):
        recorder.append(run, given.block(start, values[:, start:stop]))


@pytest.fixture
def session(tmp_path: Path) -> Path:
    path = tmp_path / "session.h5"
    with Recorder.create(path, given.plan()) as recorder:
        fill(recorder, "run_0001", given.codes(seed=1))
        recorder.write_ledger("run_0001", 1, np.arange(6.0).reshape(3, 2))
        recorder.finish("run_0001", {"stroke_use": 0.25, "force_use": 0.5}, flags=Flag.OVERRUN)
    return path


def test_codes_and_their_scale_are_those_given(session: Path) -> None:
    with h5py.File(session, "r") as file:
        force = file["run_0001/data/force"]
        assert force.dtype == np.int32
        assert force.chunks == (16384,)
        np.testing.assert_array_equal(force[:], given.codes(seed=1)[0])
        np.testing.assert_array_equal(file["run_0001/data/acceleration"][:], given.codes(seed=1)[1])
        assert force.attrs["units"] == b"N"
        assert force.attrs["scale"] == 10.0 / 2**23
        assert force.attrs["sensitivity"] == given.FORCE.sensitivity


def test_generic_viewers_find_the_default_plot(session: Path) -> None:
    with h5py.File(session, "r") as file:
        assert file.attrs["NX_class"] == b"NXroot"
        entry = file[file.attrs["default"].decode()]
        assert entry.attrs["NX_class"] == b"NXentry"
        data = entry[entry.attrs["default"].decode()]
        assert data.attrs["NX_class"] == b"NXdata"
        assert data[data.attrs["signal"].decode()].shape == (given.SAMPLES,)
        assert [name.decode() for name in data.attrs["auxiliary_signals"]] == ["acceleration"]


def test_root_and_run_attributes(session: Path) -> None:
    with h5py.File(session, "r") as file:
        assert file.attrs["schema"] == b"rig/session/1"
        assert bool(file.attrs["synthetic"]) is True
        run = dict(file["run_0003"].attrs)
        assert (run["condition"], run["repeat"], run["order"]) == (b"c02", 2, 3)
        assert run["rate"] == given.RATE
        assert run["t0"] == b"2026-11-22T00:00Z"


def test_documents_are_utf8_json_and_the_protocol_is_verbatim(session: Path) -> None:
    with h5py.File(session, "r") as file:
        assert file["session/protocol_text"][()].decode() == given.plan().protocol_text
        for name, value in given.plan().documents.items():
            assert json.loads(file[f"session/{name}"][()].decode()) == value
        assert (
            json.loads(file["session/truth/instruments"][()])
            == given.plan().truth_documents["instruments"]
        )


def test_channel_table(session: Path) -> None:
    with h5py.File(session, "r") as file:
        force, acceleration = (
            dict(file[f"session/channels/{name}"].attrs) for name in ("force", "acceleration")
        )
        assert force["serial"] == b"F1"
        assert force["filter_delay"] == 38.9375
        assert force["pole_Hz"] == pytest.approx(1 / (2 * np.pi * 2000.0), rel=1e-15)
        assert acceleration["time_constant"] == np.inf
        assert acceleration["pole_Hz"] == 0.0
        assert set(force) >= {field.name for field in dataclasses.fields(given.infos()[0])}


def test_blocks_status_scalars_and_ledger(session: Path) -> None:
    with h5py.File(session, "r") as file:
        blocks = file["run_0001/blocks"][:3]
        assert blocks["start"].tolist() == [0, 5000, 12000]
        assert blocks["count"].tolist() == [5000, 7000, 8000]
        assert blocks["clipped"].tolist() == [[0, 3]] * 3
        assert file["session/status"]["samples"].tolist() == [given.SAMPLES, 0, 0]
        assert file["session/status"]["complete"].tolist() == [1, 0, 0]
        assert file["session/status"]["flags"].tolist() == [Flag.OVERRUN, 0, 0]
        scalars = file["run_0001/scalars"]
        assert dict(zip(scalars.attrs["names"], scalars[:], strict=True)) == {
            b"force_use": 0.5,
            b"stroke_use": 0.25,
        }
        ledger = file["run_0001/truth/ledger"]
        assert ledger[:].tolist() == [[0, 0], [0, 1], [2, 3], [4, 5]]
        assert ledger.attrs["units"] == b"J"


def test_flags_are_sticky_but_a_filter_that_fills_is_no_fault(tmp_path: Path) -> None:
    with Recorder.create(tmp_path / "s.h5", given.plan(100)) as recorder:
        values = given.codes(100)
        recorder.append(
            "run_0001", given.block(0, values[:, :50], (Flag.NOT_SETTLED, Flag.OVERLOAD_HI))
        )
        recorder.append("run_0001", given.block(50, values[:, 50:], (0, Flag.GAP)))
        assert recorder.record().run("run_0001").flags == Flag.OVERLOAD_HI | Flag.GAP


def test_nothing_is_left_beside_the_file(session: Path) -> None:
    assert [entry.name for entry in session.parent.iterdir()] == ["session.h5"]


def test_an_existing_file_is_kept_unless_overwriting_is_asked(session: Path) -> None:
    with pytest.raises(SessionError, match="exists already"):
        Recorder.create(session, given.plan())
    with Recorder.create(session, given.plan(), overwrite=True) as recorder:
        assert recorder.completed() == set()


def test_a_place_that_cannot_be_written_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(SessionError, match="cannot"):
        Recorder.create(tmp_path / "missing" / "session.h5", given.plan())


def test_a_document_that_is_not_json_leaves_no_file(tmp_path: Path) -> None:
    for bad in ({"prediction": float("nan")}, {"prediction": object()}, {"status": {}}):
        with pytest.raises(SessionError):
            Recorder.create(tmp_path / "s.h5", dataclasses.replace(given.plan(), documents=bad))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "runs",
    [(), given.plan().runs[:1] * 2, (dataclasses.replace(given.plan().runs[0], condition="c9"),)],
)
def test_inconsistent_plans_are_refused(tmp_path: Path, runs: tuple[object, ...]) -> None:
    with pytest.raises(SessionError):
        Recorder.create(tmp_path / "s.h5", dataclasses.replace(given.plan(), runs=runs))


def test_gaps_and_overfull_runs_are_refused(tmp_path: Path) -> None:
    values = given.codes(1000)
    with Recorder.create(tmp_path / "s.h5", given.plan(1000, blocks=2)) as recorder:
        with pytest.raises(SessionError, match="expected 0"):
            recorder.append("run_0001", given.block(10, values[:, :10]))
        with pytest.raises(SessionError, match="no run"):
            recorder.append("run_0009", given.block(0, values))
        with pytest.raises(SessionError, match="channels"):
            recorder.append("run_0001", given.block(0, values[:1]))
        recorder.append("run_0001", given.block(0, values[:, :600]))
        with pytest.raises(SessionError, match="full"):
            recorder.append("run_0001", given.block(600, values))
        with pytest.raises(SessionError, match="not complete"):
            recorder.finish("run_0001", {"force_use": 0.0, "stroke_use": 0.0})
        recorder.append("run_0001", given.block(600, values[:, 600:]))
        with pytest.raises(SessionError, match="scalars"):
            recorder.finish("run_0001", {})
        recorder.finish("run_0001", {"force_use": 0.0, "stroke_use": 0.0})
        with pytest.raises(SessionError, match="complete already"):
            recorder.append("run_0001", given.block(1000, values))
        assert recorder.completed() == {"run_0001"}


def test_a_ledger_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    with Recorder.create(tmp_path / "s.h5", given.plan(100)) as recorder:
        for first, shape in ((0, (4, 3)), (2, (3, 2)), (-1, (2, 2))):
            with pytest.raises(SessionError, match="ledger"):
                recorder.write_ledger("run_0001", first, np.zeros(shape))


def test_runs_may_differ_in_length_rate_and_ledger(tmp_path: Path) -> None:
    runs = (
        dataclasses.replace(given.plan().runs[0], samples=700, rate=5120.0, ledger_cycles=7),
        given.plan().runs[1],
    )
    with Recorder.create(
        tmp_path / "s.h5", dataclasses.replace(given.plan(), runs=runs)
    ) as recorder:
        record = recorder.record()
        assert [run.rate for run in record.runs] == [5120.0, given.RATE]
        assert [run.planned for run in record.runs] == [700, given.SAMPLES]
        assert record.truth is not None
        assert [record.truth.ledger(run.name)[1].shape for run in record.runs] == [(7, 2), (4, 2)]
