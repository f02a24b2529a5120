"""Runs read by several processes are those read by one, and a process that is lost costs nothing
but time.
"""

import os
import signal
import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

from analysis import RunEnergy, processes, read_session
from analysis.pipeline import energies_of
from analysis.report.files import write_report
from analysis.shared_work import here, shared_by
from daq.session.record import Record, open_session
from rig.campaign.runner import run
from rig.protocol.load import load_protocol

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes are forked")

TEXT = """\
schema: rig/protocol/1
name: processes
scene: {grains: {diameter: 8 mm}}
acquire: {settle: 4 cycles, record: 6 cycles}
vary:
  scene.bed: [locked, empty, loop_back]
  drive.acceleration: [2 m/s^2, 3 m/s^2]
repeats: 3
"""


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("processes")
    run(load_protocol(TEXT), folder, workers=1)
    return folder / "session.h5"


def same(one: RunEnergy, other: RunEnergy) -> bool:
    alike = all(
        np.array_equal(getattr(one.energy, name), getattr(other.energy, name))
        for name in ("W", "W_cycles", "force", "acceleration")
    )
    return alike and (one.flags, one.ledger, one.u_noise) == (
        other.flags,
        other.ledger,
        other.u_noise,
    )


@pytest.mark.parametrize("count", [2, 5])
def test_energies_are_those_of_one_process(
    session: Path, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(processes, "MANY", 2)
    with open_session(session) as record:
        alone = energies_of(record, [info.name for info in record.runs])
        found = processes.energies_by_processes(record, count)
        assert 0 < len(found) == len(alone) < len(record.runs)  # a loop-back has no energy
        assert all(same(found[name], alone[name]) for name in alone)
        assert read_session(record, found) == read_session(record)


def test_a_report_by_processes_is_that_of_one(session: Path, tmp_path: Path) -> None:
    with open_session(session) as record:
        for name, each in (("one", here), ("three", shared_by(3))):
            write_report(read_session(record, each=each), tmp_path / name, each=each)
    one, three = (
        {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*.*")}
        for folder in (tmp_path / "one", tmp_path / "three")
    )
    assert len(one) > 4
    assert one == three


@pytest.mark.parametrize("victims", [range(1), range(2)])
def test_a_killed_process_costs_no_run(
    session: Path, victims: range, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One or both of two processes are killed at their second message."""
    here, told = os.getpid(), [0]

    def killed(record: Record, names: Iterable[str], gaps: bool) -> dict[str, RunEnergy]:
        told[0] += os.getpid() != here
        first = [info.name for info in record.runs].index(
            *names
        ) % 2  # every second run is one process's
        if told[0] == 2 and first in victims:
            os.kill(os.getpid(), signal.SIGKILL)
        return energies_of(record, names, gaps)

    monkeypatch.setattr(processes, "MANY", 2)
    monkeypatch.setattr(processes, "BATCH", 1)
    monkeypatch.setattr(processes, "energies_of", killed)
    with open_session(session) as record:
        found = processes.energies_by_processes(record, 2)
        assert 3 <= len(found) < 12
        assert read_session(record, found) == read_session(record)


def test_few_runs_take_no_processes(session: Path) -> None:
    with open_session(session) as record:
        assert processes.energies_by_processes(record, 2) == {}
