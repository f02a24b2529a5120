"""The terms of an offset: closed forms for one cause at a time, a sum that is the offset, and
silence without truth.
"""

import dataclasses
import math

import numpy as np
import pytest
from analytic_record import (
    BOX_MASS,
    GAUGE_MASS,
    IDEAL,
    NOMINAL,
    OMEGA,
    AnalyticRecord,
    Bench,
    KnownTruth,
    condition,
    dashpot_energy,
    prediction_for,
    session,
)

from analysis import read_session
from analysis.comparison.offset_terms import LARGEST_REMAINDER
from analysis.results.condition_row import TERMS, OffsetTerms
from analysis.session.ledger_columns import EXACT

BED, BOX, MASS = 300.0, 20.0, 38.1
LEVELS = (2.0, 3.0, 4.0)
EXPONENT = 2.0  # of a dashpot
TAU = NOMINAL["acceleration"].time_constant


def made(
    gains: tuple[float, float] = (1.0, 1.0),
    pole: float = 1.0,
    poured: float = 1.0,
    exact: float | None = None,
    known: bool = True,
) -> AnalyticRecord:
    """A session of dashpot beds that take `poured` times W_T, in a box with losses.

    gains: actual over certified scale. pole: actual over certified time constant of the
    accelerometer (1: ideal channels). exact: what the bed takes in the exact waveform, over W_T.
    known: truth names the instruments.
    """
    table = [
        condition(f"c{k}", acceleration_set=a, settle_cycles=2, record_cycles=8)
        for k, a in enumerate(LEVELS)
    ]
    channels = dict(IDEAL)
    if pole != 1.0:
        channels["acceleration"] = dataclasses.replace(IDEAL["acceleration"], time_constant=TAU)

    def high_pass(tau: float) -> complex:
        return 1j * OMEGA * tau / (1 + 1j * OMEGA * tau)

    # the stand-in turns the signal by the certified pole and `turn`; what the poles do to its size
    # stands in `gains`
    turned = high_pass(TAU * pole) / high_pass(TAU)
    size = abs(high_pass(TAU * pole)) if pole != 1.0 else 1.0
    bench = Bench(
        channels, (gains[0], gains[1] * size), float(np.angle(turned)), samples=11 * 512, repeats=2
    )
    prediction = prediction_for(table, lambda _entry, a: dashpot_energy(BED, a))
    record = session(table, lambda _entry, _r: BOX + poured * BED, bench, np.random.default_rng(1),
                     prediction=prediction)  # fmt: skip
    levels = {entry["id"]: entry["acceleration_set"] for entry in table}
    ledgers = {}
    for run in record.runs:
        bed, box = (dashpot_energy(c, levels[run.condition]) for c in (BED, BOX))
        columns = {"W_viscous": poured * bed, "W_noise": box, "dKE_bed": 0.0, "closure": 0.0}
        if exact is not None:
            columns[EXACT] = exact * bed
        ledgers[run.name] = (tuple(columns), np.tile(list(columns.values()), (50, 1)))
    states = {
        name: {"sensitivity": channel.sensitivity * gain, "gain": 1.0,
               "time_constant": channel.time_constant and channel.time_constant * pole}
        for (name, channel), gain in zip(channels.items(), gains, strict=True)
    }  # fmt: skip
    documents = {"instruments": states, "clock": {"error": 0.0}} if known else {}
    return dataclasses.replace(record, truth=KnownTruth(ledgers, documents))


def terms_of(record: AnalyticRecord) -> list[OffsetTerms]:
    rows = read_session(record).conditions
    assert [row.offset_terms is None for row in rows] == [False] * len(rows)
    for row in rows:
        assert [name for name, _ in row.offset_terms.named()] == list(TERMS)
        assert math.fsum(value for _, value in row.offset_terms.named()) == pytest.approx(
            row.offset, abs=1e-12
        )
    return [row.offset_terms for row in rows]


# the loop's velocity is integrated numerically: relative error of W far below 1e-6 at 512 samples
# per cycle
SMALL = 1e-6


def test_losses_of_the_box_are_the_whole_offset_where_all_else_is_ideal() -> None:
    for terms in terms_of(made()):
        assert terms.noise == pytest.approx(BOX / BED, rel=1e-9)
        assert all(abs(value) < SMALL for name, value in terms.named() if name != "noise")


@pytest.mark.parametrize("gains", [(1.01, 1.0), (1.0, 0.99), (0.995, 1.02)])
def test_scale_enters_the_measured_energy_once_and_the_predicted_one_by_its_exponent(
    gains: tuple[float, float],
) -> None:
    """W_T is a^2 here: scale = [(1+s_F)(1+s_a) - 1] E - [(1+s_a)^2 - 1] W_T(true a), over
    W_T(measured a).
    """
    s_F, s_a = gains
    measured = s_a**EXPONENT
    expected = ((s_F * s_a - 1.0) * (1.0 + BOX / BED) - (measured - 1.0)) / measured
    for terms in terms_of(made(gains)):
        assert terms.scale == pytest.approx(expected, abs=SMALL)
        assert abs(terms.remainder) < SMALL
        assert terms.phase == 0.0


@pytest.mark.parametrize("pole", [0.7, 1.3])
def test_phase_is_a_rotation_by_the_angle_that_correction_leaves(pole: float) -> None:
    """(pi/w^2) M_eff a^2 dphi, dphi = atan(1/(w tau_true)) - atan(1/(w tau_certified)), of either
    sign.
    """
    angle = math.atan(1 / (OMEGA * TAU * pole)) - math.atan(1 / (OMEGA * TAU))
    for terms, a in zip(terms_of(made(pole=pole)), LEVELS, strict=True):
        reactive = math.pi / OMEGA**2 * (BOX_MASS + GAUGE_MASS + MASS) * a**2
        # W (1 - cos) = 1e-6 and the pole's change of size, 1e-5, beside it
        assert terms.phase == pytest.approx(
            reactive * math.sin(angle) / dashpot_energy(BED, a), rel=1e-4
        )
        assert abs(terms.remainder) < 1e-5


def test_refill_and_waveform_share_what_the_bed_takes_beyond_the_prediction() -> None:
    for terms in terms_of(made(poured=1.05)):
        assert terms.refill == pytest.approx(0.05, abs=SMALL)
        assert terms.waveform == 0.0
    for terms in terms_of(made(poured=1.05, exact=1.04)):
        assert terms.refill == pytest.approx(0.04, abs=SMALL)
        assert terms.waveform == pytest.approx(0.01, abs=SMALL)


def test_all_causes_together_leave_no_remainder() -> None:
    for terms in terms_of(made((1.004, 0.993), 1.2, 0.97, 0.96)):
        assert abs(terms.remainder) < LARGEST_REMAINDER / 100


def test_terms_need_truth_that_names_the_instruments_and_an_offset() -> None:
    record = made()
    for other in (made(known=False), dataclasses.replace(record, truth=None)):
        assert [row.offset_terms for row in read_session(other).conditions] == [None] * len(LEVELS)
    bare = dataclasses.replace(record, documents={})
    assert [row.offset_terms for row in read_session(bare).conditions] == [None] * len(LEVELS)


def test_without_truth_nothing_else_changes() -> None:
    record = made((1.004, 0.993), 1.2, 0.97)
    with_truth, without = (
        read_session(record),
        read_session(dataclasses.replace(record, truth=None)),
    )
    fed = dict.fromkeys(("offset_terms", "E_n_truth", "dKE_bed"))
    for one, other in zip(with_truth.conditions, without.conditions, strict=True):
        assert dataclasses.replace(one, **fed) == dataclasses.replace(other, **fed)
