"""The report of a session: keys, numbers, verdict; and what may not change them."""

import dataclasses
import json
import math

import numpy as np
import pytest
from analytic_record import (
    BOX_MASS,
    IDEAL,
    NOMINAL,
    Bench,
    KnownTruth,
    condition,
    dashpot_energy,
    prediction_for,
    session,
)

from analysis import AnalysisError, agreement, read_session, run_energy
from analysis.results.report import LeftOutRun

LEVELS = (2.0, 3.0, 4.0)
BED, BOX = 300.0, 20.0  # N s/m: of the full bed, of the box


def conditions():
    return [
        condition(
            f"c{i}{j}",
            fill=fill,
            bed_mass=44.8 * fill,
            carried=fill == 1,
            acceleration_set=a,
            settle_cycles=2,
            record_cycles=8,
        )
        for i, fill in enumerate((0.0, 0.5, 0.9, 1.0))
        for j, a in enumerate(LEVELS)
    ]


def bed(fill):
    return BED * fill if fill < 1 else 0.0


def made(bench=None, seed=1, box=BOX):
    bench = dataclasses.replace(bench or Bench(), samples=11 * 512)
    table = conditions()
    prediction = prediction_for(table, lambda entry, a: dashpot_energy(bed(entry["fill"]), a))
    documents = {
        "prediction": prediction,
        "protocol": {"name": "demo"},
        "rig": {
            "values": [
                {
                    "path": "wall_friction",
                    "value": 0.45,
                    "unit": "",
                    "status": "assumed",
                    "source": "us",
                }
            ]
        },
    }
    return session(
        table,
        lambda entry, _repeat: box + bed(entry["fill"]),
        bench,
        np.random.default_rng(seed),
        **documents,
    )


@pytest.fixture(scope="module")
def record():
    return made(
        Bench(channels=dict(NOMINAL), noise=(0.02, 5e-4), level_error=0.003, gains=(1.002, 0.999))
    )


@pytest.fixture(scope="module")
def report(record):
    return read_session(record)


def test_all_names_of_the_contract_are_there(report):
    document = report.document()
    assert {
        "schema",
        "protocol",
        "synthetic",
        "tests",
        "waveform",
        "conditions",
        "agreement",
        "claims",
        "nulls",
        "ledger",
        "verdict",
    } <= set(document)
    assert {
        "id",
        "material",
        "density",
        "diameter",
        "fill",
        "bed",
        "drive",
        "bed_mass",
        "frequency",
        "acceleration_set",
        "acceleration",
        "period",
        "periodic_share",
        "dKE_bed",
        "runs",
        "W_exp",
        "s_W_exp",
        "U_W_exp",
        "k",
        "nu",
        "W_net",
        "W_detect",
        "eta",
        "M_eff",
        "thd_force",
        "thd_box",
        "W_T",
        "U_W_T",
        "W_f",
        "W_c",
        "W_T_as_printed",
        "bound",
        "exponent",
        "offset",
        "E_n",
        "E_n_truth",
        "offset_terms",
        "uncertainty",
    } <= set(document["conditions"][0])
    assert {
        "run",
        "order",
        "acceleration",
        "W_exp",
        "W_exc",
        "W_kin",
        "W_phasor",
        "W_eq25",
        "W_coil",
        "cycles",
        "flags",
    } <= set(document["conditions"][0]["runs"][0])
    assert {"source", "u", "c", "nu", "share"} <= set(document["conditions"][0]["uncertainty"][0])
    assert {"ratio", "U_ratio", "slope", "mean_offset", "n"} <= set(document["agreement"])
    assert {"null", "dphi", "U_dphi", "verdict"} <= set(document["nulls"][0])
    json.dumps(document, allow_nan=False)
    assert (report.tests, report.waveform, report.protocol) == ("measurement", "ideal", "demo")
    assert report.verdict == "passes"


def test_numbers_of_a_condition(report):
    row = next(row for row in report.conditions if row.id == "c22")
    true = dashpot_energy(BOX + 0.9 * BED, 4.0)
    assert row.W_exp == pytest.approx(true, rel=0.01)
    assert abs(row.W_exp - true) < row.U_W_exp
    assert row.M_eff == pytest.approx(BOX_MASS + 0.02 + 0.9 * 44.8, rel=5e-3)
    assert row.exponent == pytest.approx(2.0)
    assert row.W_f + row.W_c == pytest.approx(row.W_T)
    assert row.offset == pytest.approx(row.W_exp / row.W_T - 1)
    assert abs(row.E_n_truth) < 1
    assert math.fsum(line.share for line in row.uncertainty) == pytest.approx(1)
    u = math.sqrt(math.fsum((line.c * line.u) ** 2 for line in row.uncertainty))
    assert row.U_W_exp == pytest.approx(row.k * u)
    empty = next(row for row in report.conditions if row.id == "c02")
    assert row.W_net == pytest.approx(row.W_exp - empty.W_exp)
    assert empty.W_T == 0
    assert empty.offset is empty.E_n is None


def test_ratio_and_no_slope_where_there_is_no_line():
    """With ideal instruments: ratio = sum of all losses over the bed's; slope and offsets from the
    same numbers.
    """
    report = read_session(made())
    told = [row for row in report.conditions if row.W_T > 0]
    W_exp = [dashpot_energy(BOX + bed(row.fill), row.acceleration_set) for row in told]
    W_T = [dashpot_energy(bed(row.fill), row.acceleration_set) for row in told]
    found = report.agreement
    assert found.ratio == pytest.approx(sum(W_exp) / sum(W_T), rel=1e-8)
    ratios = np.divide(W_exp, W_T)
    # ideal instruments, and box losses that are not in proportion to the bed's: no line goes
    # through within U
    assert np.ptp(ratios) > 0.01
    assert found.slope is found.U_slope is found.line.slope is found.line.intercept is None
    assert found.line.chi2 > 100 * found.line.dof
    offsets = [e / t - 1 for e, t in zip(W_exp, W_T, strict=True)]
    assert found.mean_offset == pytest.approx(np.mean(offsets), rel=1e-8)
    assert (
        found.put_in is None
    )  # this stand-in's ledger does not tell the box's losses from the bed's
    assert found.n == len(told) == 6
    assert all(row.s_W_exp < 1e-12 for row in report.conditions)
    assert max(row.E_n_truth for row in report.conditions) < 1e-3


def test_acceleration_scale_counts_as_one_minus_n():
    """W_T ~ a^2 at the measured level: an accelerometer that reads e too high makes W_exp / W_T
    fall by e, n = 2.
    """
    e = 0.004
    ratio = {
        gain: read_session(made(Bench(gains=(1.0, gain)))).agreement.ratio for gain in (1.0, 1 + e)
    }
    assert ratio[1 + e] / ratio[1.0] - 1 == pytest.approx(-e, rel=2 * e)
    facts = {
        **IDEAL,
        "acceleration": dataclasses.replace(IDEAL["acceleration"], calibration_U=0.01),
    }
    found = read_session(made(Bench(channels=facts))).agreement
    # |1 - n| U = U for n = 2; common to all conditions, it does not average out. k of t(50) is 2.01.
    assert found.U_ratio / found.ratio == pytest.approx(2.01 * 0.005, rel=0.01)


def test_without_truth_nothing_measured_changes(record, report):
    bare = read_session(dataclasses.replace(record, truth=None))
    for with_truth, without in zip(report.conditions, bare.conditions, strict=True):
        truth = {"E_n_truth": None, "dKE_bed": None}
        assert dataclasses.replace(with_truth, **truth) == dataclasses.replace(without, **truth)
        assert without.E_n_truth is None
    assert bare.nulls == report.nulls
    assert dataclasses.replace(bare.agreement, put_in=0.0) == dataclasses.replace(
        report.agreement, put_in=0.0
    )
    assert bare.ledger.closure_max is None
    assert bare.verdict == "passes"


def test_one_run_at_a_time_is_the_same(record, report):
    energies = {run.name: run_energy(record, run.name) for run in record.runs}
    assert read_session(record, energies) == report


def test_a_chain_that_lies_fails():
    """The ledger says 3 % less than is measured: with 0.5 % instruments no condition agrees."""
    record = made(Bench(channels=dict(NOMINAL)))
    lies = {name: (columns, 0.95 * rows) for name, (columns, rows) in record.truth.ledgers.items()}
    report = read_session(dataclasses.replace(record, truth=KnownTruth(lies)))
    assert report.verdict == "fails"
    assert report.chain.share < 0.9


def test_an_account_that_does_not_close_fails():
    record = made()
    leaky = {
        name: (columns, np.add(rows, [0, 0, 1e-6]))
        for name, (columns, rows) in record.truth.ledgers.items()
    }
    report = read_session(dataclasses.replace(record, truth=KnownTruth(leaky)))
    assert report.verdict == "fails"
    assert report.ledger.closure_max == pytest.approx(1e-6)


def test_overload_fails_and_is_listed():
    report = read_session(dataclasses.replace(made(), block_flags=1))
    assert report.verdict == "fails"
    assert report.flags[0].flag == "overload_hi"
    assert len(report.flags[0].runs) == 48


def test_runs_with_missing_samples_are_refused_and_left_out():
    record = dataclasses.replace(made(), block_flags=16)
    with pytest.raises(AnalysisError, match="gap"):
        run_energy(record, record.runs[0])
    report = read_session(record)
    assert report.conditions == ()
    assert len(report.left_out) == 48
    assert report.verdict == "fails"


def test_an_unfinished_run_is_left_out():
    record = made()
    runs = (dataclasses.replace(record.runs[0], complete=False), *record.runs[1:])
    report = read_session(dataclasses.replace(record, runs=runs))
    assert report.left_out == (LeftOutRun("run_0001", "run_0001 is not complete"),)
    assert len(report.conditions[0].runs) == 3


def test_settling_is_no_fault():
    assert read_session(dataclasses.replace(made(), block_flags=128)).verdict == "passes"


def test_exciter_beyond_its_limit_is_a_flag_that_fails_nothing(monkeypatch):
    record = made()
    monkeypatch.setattr(
        type(record), "scalars", lambda _self, _run: {"use_force": 1.2, "use_stroke": 0.4}
    )
    report = read_session(record)
    assert [(entry.flag, entry.worst) for entry in report.flags] == [("over_force", 1.2)]
    assert report.verdict == "passes"


def test_long_records_use_every_cycle():
    table = [condition("c1", record_cycles=150, settle_cycles=2)]
    record = session(
        table, lambda _e, _r: 300.0, Bench(samples=153 * 512, repeats=1), np.random.default_rng(0)
    )
    record = dataclasses.replace(record, truth=None)
    energy = run_energy(record, "run_0001").energy
    assert energy.cycles == 150
    assert pytest.approx(dashpot_energy(300, 5.0), rel=1e-9) == energy.W


def test_plain_numbers_and_one_condition_are_enough():
    """The door for a laboratory's own data: energies, conditions, a table of two columns,
    certificates.
    """
    record = made()
    runs = [run_energy(record, run) for run in record.runs if run.condition == "c21"]
    runs = [dataclasses.replace(run, ledger=None) for run in runs]
    prediction = {"conditions": {"c21": {"acceleration": [3.0], "W_T": [0.01]}}}
    report = agreement(runs, {"c21": record.conditions["c21"]}, prediction, IDEAL)
    assert report.tests == "model"
    assert report.agreement.n == 1
    assert report.conditions[0].exponent is None
    no_prediction = agreement(runs, {"c21": record.conditions["c21"]}, None, IDEAL)
    assert no_prediction.agreement.ratio is None
    assert no_prediction.conditions[0].W_T is None


def test_a_condition_that_lacks_a_key_is_named():
    record = made()
    broken = {
        name: {k: v for k, v in entry.items() if k != "box_mass"}
        for name, entry in record.conditions.items()
    }
    with pytest.raises(AnalysisError, match="box_mass"):
        read_session(dataclasses.replace(record, conditions=broken))
