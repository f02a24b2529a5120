"""The kernel against the engine table, and the measures of a shaken box."""

import numpy as np
import pytest

from rig.benchmarks.grains.engine_table import judged, lines, runs, table_cases
from rig.benchmarks.grains.plain_curves import plain_curves
from rig.benchmarks.grains.shaking import G, ShakenBox, shake


def test_a_shallow_bed_takes_what_the_table_gives() -> None:
    # Case 4: 261 grains at 7 m/s^2, where packings scatter by 3 %: two of them within 10 %.
    case = table_cases()[4]
    rows = []
    for seed in (1, 2):
        found = shake(case.box, case.box.poured(seed), case.settle, case.cycles)
        # Of the account, from the packing at rest to the last cycle.
        assert found.gap < 1e-11
        rows.append(
            {
                "case": case.number,
                "grains": found.mass / case.box.ball_mass,
                "work": found.work.mean(),
                "in_phase": found.in_phase.mean(),
            }
        )
    (verdict,) = judged(rows)
    assert verdict.work == pytest.approx(case.work, rel=0.1)
    assert verdict.in_phase == pytest.approx(case.in_phase, abs=0.06)
    assert verdict.grains == pytest.approx(case.grains, rel=0.05)
    assert verdict.holds
    assert lines([verdict])[-1] == "1 of 1 hold."


def test_a_bed_far_below_its_yield_rides_with_the_box() -> None:
    # A cycle needs a step that resolves contacts; the in-phase mass of a rigid bed is its own. At
    # .01 g what moves are the contacts' springs: (w sqrt(m/k) layers)^2 = 1e-4 of it.
    box = ShakenBox(0, 0.03, 0.03, 0.03, 5e-3, 0.6, 40.0, 0.01 * G)
    found = shake(box, box.poured(1), 6, 4)
    assert found.in_phase.mean() == pytest.approx(1.0, abs=0.02)
    assert abs(found.work.mean()) < 0.05 * np.pi * box.scale(found.mass)


def test_low_levels_take_fewer_packings() -> None:
    cases = table_cases()
    assert len(cases) == 35
    todo = list(runs(cases, 6))
    low = [case for case in cases if case.low]
    assert len(todo) == 6 * 35 - 2 * len(low)


def test_plain_curves_find_what_they_can_describe() -> None:
    level = np.geomspace(0.7, 2.0, 12)
    found = plain_curves(level.tolist(), (1.3 * level**-1.5).tolist())
    for degree in (1, 2, 3, 4):
        curve = found[f"polynomial of degree {degree} in ln(a/g)"]
        assert curve(1.1) == pytest.approx(1.3 * 1.1**-1.5, rel=1e-9)
    assert found["polynomial of degree 0 in ln(a/g)"](1.1) == pytest.approx(
        np.exp(np.mean(np.log(1.3 * level**-1.5)))
    )
