"""Refills of the prediction: sums over tabulated layers, against beds that are computed one by one."""

import numpy as np
import pytest

from rig.beds.janssen_stack import refill
from rig.catalog.rig_file import load_rig
from rig.prediction.model import predict
from rig.prediction.own import total_of
from rig.prediction.refills import COUNT, refill_ratios
from rig.protocol.grid import conditions
from rig.protocol.load import load_protocol

TEXT = """\
schema: rig/protocol/1
name: refills
scene: {{grains: {{material: stainless, diameter: 8 mm, fill: {fill}}}, bed: {bed}}}
drive: {{acceleration: {a} m/s^2}}
"""


def found(fill, a, bed="layers"):
    protocol = load_protocol(TEXT.format(fill=fill, a=a, bed=bed))
    (condition,), rig = conditions(protocol), load_rig(protocol.rig)
    return condition, rig, refill_ratios(condition, rig, predict(condition, rig).W_T)


@pytest.mark.parametrize(("fill", "a"), [("90 %", 5), ("95 %", 3)])
def test_refills_scatter_as_beds_poured_one_by_one(fill, a):
    """Means within 4 standard deviations of the 60 beds' (the tabulated ones' is smaller), a chance
    of 1e-4; standard deviations within 4 of theirs, 1/sqrt(2 n) of both for normal ones, and half
    as much again for long tails."""
    condition, rig, ratios = found(fill, a)
    scene, drive, rng, n = condition.scene, condition.drive, np.random.default_rng(3), 60
    W_T = predict(condition, rig).W_T
    beds = [refill(scene, rig, rng) for _ in range(n)]
    W = (
        np.array(
            [total_of(scene, rig, bed, drive.acceleration, drive.frequency).total for bed in beds]
        )
        / W_T
    )
    s = float(W.std(ddof=1))
    assert np.mean(ratios) == pytest.approx(W.mean(), abs=4 * s * np.sqrt(1 / n + 1 / COUNT))
    assert np.std(ratios, ddof=1) == pytest.approx(
        s, rel=4 * 1.5 * np.sqrt(1 / (2 * n) + 1 / (2 * COUNT))
    )


def test_beds_that_pouring_does_not_change_have_none():
    assert found("85 %", 5, "locked")[2] == ()
    assert found("100 %", 5)[2] == ()
    assert found("0 %", 5)[2] == ()


def test_they_are_the_same_whenever_they_are_asked_for():
    assert found("85 %", 4)[2] == found("85 %", 4)[2]
