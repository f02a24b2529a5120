"""The marks of each candidate cause, against the powers and shares that they were made with."""

import math

import numpy as np
import pytest
from analytic_record import (
    BOX_MASS,
    GAUGE_MASS,
    IDEAL,
    NOMINAL,
    OMEGA,
    Bench,
    condition,
    prediction_for,
    session,
)

from analysis import read_session
from analysis.results.session_rows import CauseRow, Span

RIG = {
    "loss_noise": 20.0,
    "loss_air": 900.0,
    "guide_friction": 0.006,
    "gravity": 9.80665,
    "cord_frequency": 2.0,
    "cord_loss_factor": 0.1,
}
LEVELS = (2.0, 3.0, 4.0)
FILLS = (0.0, 0.3, 0.6, 0.9, 1.0)
POWER = 3.0  # of W_T in a; it is proportional to fill


def predicted(entry: dict, a: float) -> float:
    return 1e-3 * a**POWER * entry["fill"] * (entry["fill"] < 1)


def noise(a: float) -> float:
    return math.pi * RIG["loss_noise"] * a**2 / OMEGA**3


def made(fills=FILLS, channels=IDEAL, listed=("noise",), values=RIG, **facts):
    """Beds that take W_T in a box with viscous losses; the ledger tells the two apart."""
    table = [
        condition(
            f"c{i}{j}",
            fill=fill,
            bed_mass=44.8 * fill,
            carried=fill == 1,
            acceleration_set=a,
            settle_cycles=2,
            record_cycles=8,
            losses=list(listed),
            support="guide",
            **facts,
        )
        for i, fill in enumerate(fills)
        for j, a in enumerate(LEVELS)
    ]

    def coefficient(entry, _repeat):
        return RIG["loss_noise"] + predicted(entry, entry["acceleration_set"]) * OMEGA**3 / (
            math.pi * entry["acceleration_set"] ** 2
        )

    documents = {
        "prediction": prediction_for(table, predicted),
        "rig": {"values": [{"path": k, "value": v, "unit": "", "status": "assumed", "source": ""}
                           for k, v in values.items()]},
    }  # fmt: skip
    bench = Bench(dict(channels), samples=11 * 512, repeats=1)
    record = session(table, coefficient, bench, np.random.default_rng(1), **documents)
    for run in record.runs:
        a = record.conditions[run.condition]["acceleration_set"]
        row = [predicted(record.conditions[run.condition], a), noise(a), 0.0, 0.0]
        record.truth.ledgers[run.name] = (
            ("W_c", "W_noise", "W_gas", "closure"),
            np.tile(row, (50, 1)),
        )
    return record


def rows_of(record) -> dict[str, CauseRow]:
    return {row.cause: row for row in read_session(record).causes}


FULL = sum(1e-3 * a**POWER * 0.9 for a in LEVELS)


def test_each_cause_grows_as_its_law_says() -> None:
    rows = rows_of(made())
    expected = {
        "noise": (2, 0),
        "air": (3, 0),
        "guide friction": (1, 1),
        "cords": (2, 1),
        "measured excess": (2, 0),
    }
    for name, (a, mass) in expected.items():
        grows = rows[name].grows_with
        assert grows.acceleration == pytest.approx(a, abs=1e-6)
        assert grows.mass == pytest.approx(mass, abs=1e-6)


def test_what_the_empty_and_the_locked_box_keep() -> None:
    rows = rows_of(made())
    kept = sum(noise(a) for a in LEVELS) / FULL
    for name in ("noise", "measured excess"):
        assert rows[name].empty == pytest.approx(kept, rel=1e-6)
        assert rows[name].locked == pytest.approx(kept, rel=1e-6)
        assert rows[name].empty_from == rows[name].locked_from == "run"
    guide = rows["guide friction"]
    weight = 4 * RIG["guide_friction"] * RIG["gravity"] * sum(LEVELS) / OMEGA**2 / FULL
    assert guide.empty == pytest.approx(weight * (BOX_MASS + GAUGE_MASS), rel=1e-6)
    assert guide.locked == pytest.approx(weight * (BOX_MASS + GAUGE_MASS + 44.8), rel=1e-6)
    assert guide.empty_from == guide.locked_from == "computed"
    assert not guide.in_run
    assert rows["noise"].in_run


def test_boxes_that_are_not_in_the_run_are_computed() -> None:
    """Without an empty and a locked condition the closed forms say the same of the same rig."""
    whole, part = rows_of(made()), rows_of(made((0.3, 0.6, 0.9)))
    for name in ("noise", "air", "guide friction", "cords"):
        assert part[name].empty == pytest.approx(whole[name].empty, rel=1e-6)
        assert part[name].empty_from == "computed"
    assert part["gas"].empty == part["gas"].locked == 0.0
    assert part["measured excess"].empty is None


def test_shares_are_weighted_with_energy() -> None:
    rows = rows_of(made())
    total = sum(1e-3 * a**POWER * fill for a in LEVELS for fill in (0.3, 0.6, 0.9))
    assert rows["noise"].share == pytest.approx(3 * sum(map(noise, LEVELS)) / total, rel=1e-6)
    assert rows["measured excess"].share == pytest.approx(rows["noise"].share, rel=1e-6)


def test_sensor_causes_are_as_large_as_the_certificates_allow() -> None:
    ideal, real = rows_of(made()), rows_of(made(channels=NOMINAL))
    assert real["scale"].share > 100 * ideal["scale"].share == 0.0
    # the angle that arithmetic may leave, 5e-6 rad (1 sigma), is all that ideal channels keep
    assert real["sensor phase"].share > 10 * ideal["sensor phase"].share > 0.0
    assert real["sensor phase"].grows_with.acceleration == pytest.approx(2.0, abs=0.05)
    # beside mass, a dashpot bed changes no apparent mass
    assert real["sensor phase"].grows_with.mass == pytest.approx(1.0, abs=0.05)
    assert real["scale"].empty < 0.1 * real["scale"].share


def test_gas_says_whether_it_was_switched_on() -> None:
    facts = {"on": False, "share_of_weight": 0.004}
    assert rows_of(made())["gas"].note == "not listed in this run"
    off = rows_of(made(listed=("noise", "gas"), gas=facts))["gas"]
    assert off.note == "off, 0.4 % to 0.4 % of the bed's weight"
    assert off.share == 0.0
    assert rows_of(made(listed=("gas",), gas=facts | {"on": True}))["gas"].note.startswith("on, ")


def test_no_rig_no_table() -> None:
    assert read_session(made(values={"gravity": 9.8})).causes == ()


def test_coefficients_of_the_conditions_where_the_rig_file_leaves_them_out() -> None:
    """The same numbers give the same rows wherever they are written; without them, no table."""
    left = {name: value for name, value in RIG.items() if not name.startswith("loss_")}
    own = {"noise": RIG["loss_noise"], "air": RIG["loss_air"]}
    assert rows_of(made(values=left, loss_coefficients=own)) == rows_of(made())
    doubled = rows_of(made(values=left, listed=(), loss_coefficients=own | {"air": 1800.0}))
    once = rows_of(made(listed=()))
    assert doubled["air"].share == pytest.approx(2.0 * once["air"].share, rel=1e-12)
    assert doubled["noise"] == once["noise"]
    assert read_session(made(values=left)).causes == ()


def test_losses_beside_first_principles_as_the_session_tells_them() -> None:
    """Low and high over the conditions; nothing for causes that have no such size, and where no
    session tells.
    """
    rows = rows_of(made(over_first_principles={"noise": 3.0, "air": 0.0}))
    found = {name: row.over_first_principles for name, row in rows.items()}
    assert (found.pop("noise"), found.pop("air")) == (Span(3.0, 3.0), Span(0.0, 0.0))
    assert set(found.values()) == {None}
    assert {row.over_first_principles for row in rows_of(made()).values()} == {None}
