"""The same analysis on the product's own session file, filled with codes of exact signals."""

import h5py
import numpy as np
import pytest
from analytic_record import (
    FILTER_DELAY,
    NOMINAL,
    OMEGA,
    condition,
    dashpot_energy,
    drive_time,
    motion,
    prediction_for,
)

from analysis import read_session, run_energy
from daq.chain.block import Block
from daq.chain.channel import AnalyzerSpec, Channel, TransducerSpec, channel_info
from daq.session.plan import RunPlan, SessionPlan
from daq.session.record import open_session
from daq.session.writer import Recorder

RATE, SAMPLES, CUT = 10240.0, 51 * 512, 7000
MASS, LOSS, A0 = 38.0, 400.0, 5.0

FORCE = TransducerSpec("208C03", "force", "N", 2.248e-3, 2200.0, 2000.0, 0.1, 0.02, 1e4, 0.01)
ACCELERATION = TransducerSpec(
    "352C33", "acceleration", "m/s^2", 0.0102, 490.0, 1.6, 0.1, 1.5e-3, 1e4, 0.01
)
ANALYZER = AnalyzerSpec("INV-3118", (51200.0, RATE))


def plan():
    entry = condition("c01")
    infos = tuple(
        channel_info(Channel(spec.quantity, spec, volts, "1", "+x"), ANALYZER, RATE, FILTER_DELAY)
        for spec, volts in ((FORCE, 10.0), (ACCELERATION, 1.0))
    )
    return SessionPlan(
        rate=RATE,
        channels=infos,
        conditions=(entry,),
        protocol_text="name: demo\n",
        protocol={"name": "demo"},
        runs=tuple(RunPlan(f"run_{i:04d}", "c01", i, i, SAMPLES, 5159, 8) for i in (1, 2)),
        documents={
            "prediction": prediction_for([entry], lambda _entry, a: dashpot_energy(LOSS, a), 1e-3)
        },
        ledger_columns=("W_viscous", "dKE_bed", "closure"),
        ledger_cycles=50,
        scalars=("use_force", "use_stroke"),
    )


def codes(infos):
    """Converter codes of a dashpot beside a mass, each channel turned by its certified pole as the
    hardware would.
    """
    t = drive_time(SAMPLES)
    rows = []
    for info in infos:
        gain = 1j * OMEGA * info.time_constant / (1 + 1j * OMEGA * info.time_constant)
        a, v = motion(t + np.angle(gain) / OMEGA, A0 * abs(gain))
        signal = MASS * a + LOSS * v if info.name == "force" else a
        rows.append(np.rint(signal * info.sensitivity / info.scale))
    return np.array(rows, dtype=np.int32)


@pytest.fixture
def session(tmp_path):
    """A finished session of two runs, the energies read while it was still open, and its path."""
    path = tmp_path / "session.h5"
    found = plan()
    read = codes(found.channels)
    early = {}
    with Recorder.create(path, found) as recorder:
        for run in found.runs:
            for start in range(0, SAMPLES, CUT):
                part = read[:, start : start + CUT]
                recorder.append(
                    run.name,
                    Block(start, part, np.zeros(2, np.uint16), np.zeros(2, np.uint32), False),
                )
            recorder.write_ledger(
                run.name, 0, np.tile([dashpot_energy(LOSS, A0), 0.0, 1e-15], (50, 1))
            )
            recorder.finish(run.name, {"use_force": 0.7, "use_stroke": 1.1})
            early[run.name] = run_energy(recorder.record(), run.name)
    return path, early


def test_energy_from_codes(session):
    """Rounding to 24 bits: noise of 0.29 code per sample, 1e-9 of W; poles undone by the channel
    table.
    """
    path, early = session
    with open_session(path) as record:
        energy = run_energy(record, record.runs[0]).energy
    assert energy.cycles == 40
    assert dashpot_energy(LOSS, A0) == pytest.approx(energy.W, rel=1e-6)
    assert energy.M_eff == pytest.approx(MASS, rel=1e-6)
    assert early["run_0001"].energy.W == energy.W


def test_report_of_a_file(session):
    path, early = session
    with open_session(path) as record:
        report = read_session(record)
        assert read_session(record, early) == report
    assert report.protocol == "demo"
    assert [entry.flag for entry in report.flags] == ["over_stroke"]
    row = report.conditions[0]
    assert abs(row.offset) < 1e-5
    assert abs(row.E_n_truth) < 1e-3
    assert row.U_W_exp / row.W_exp > NOMINAL["force"].calibration_U / 2
    assert report.verdict == "passes"


def test_a_file_without_truth_gives_the_same_measurement(session):
    path, _ = session
    with open_session(path) as record:
        full = read_session(record).document()["conditions"][0]
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        del file["session/truth"]
        for run in ("run_0001", "run_0002"):
            del file[run]["truth"]
    with open_session(path) as record:
        bare = read_session(record).document()["conditions"][0]
    assert {name for name in full if full[name] != bare[name]} == {"E_n_truth", "dKE_bed"}
