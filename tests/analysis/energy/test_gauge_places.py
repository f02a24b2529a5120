"""Gauge and accelerometer at either end of the stinger: readings made from a known box, and the box
told from them.
"""

from dataclasses import replace

import numpy as np
import pytest
from bare_rows import bare

from analysis.energy.energy_and_phasors import Energy
from analysis.energy.gauge_position import at_box
from analysis.session.exciter import SessionExciter
from rig.protocol.spec import GaugeSide

EXCITER = bare(SessionExciter, stinger_stiffness=5e6, stinger_damping=150.0, parts_U=0.1)
FREQUENCY, MASS, LOAD, DASHPOT = 40.0, 0.8, 30.0, 60.0
ENDS: tuple[GaugeSide, ...] = ("box", "exciter")


def energy(force: np.ndarray, acceleration: np.ndarray) -> Energy:
    """What a run with these phasors would be read as, its coherent work as its W."""
    jw = 2j * np.pi * FREQUENCY * np.arange(1, force.size + 1)
    W = -0.5 / FREQUENCY * float(((force * acceleration.conj()).imag / jw.imag).sum())
    return Energy(FREQUENCY, 10, W, np.full(10, W), W, 0.0, W, force, acceleration)


@pytest.mark.parametrize("gauge", ENDS)
@pytest.mark.parametrize("accelerometer", ENDS)
def test_the_box_is_told_from_any_place(gauge: str, accelerometer: str) -> None:
    """A load of 30 kg and 60 N s/m behind a stinger, 7 harmonics: its own mass and work come back
    to round-off.
    """
    orders = np.arange(1, 8)
    jw = 2j * np.pi * FREQUENCY * orders
    a = np.exp(1j * orders) * 5.0 / orders**2
    on_box = (LOAD + DASHPOT / jw) * a
    pull = on_box + (MASS * a if gauge == "box" else 0.0)
    other = a + jw**2 * pull / (EXCITER.stinger_stiffness + jw * EXCITER.stinger_damping)
    force = pull + (MASS * other if gauge == "exciter" else 0.0)
    read = energy(force, other if accelerometer == "exciter" else a)
    found = at_box(read, gauge, accelerometer, MASS, EXCITER)
    work = (
        np.pi
        * DASHPOT
        * float((np.abs(a) ** 2 / (jw.imag**2 * 2 * np.pi * FREQUENCY * orders) * orders).sum())
    )
    assert pytest.approx(work, rel=1e-12) == found.W
    assert found.M_eff == pytest.approx(LOAD, rel=1e-12)
    assert found.level == pytest.approx(abs(a[0]), rel=1e-12)


@pytest.mark.parametrize("gauge", ENDS)
@pytest.mark.parametrize("accelerometer", ENDS)
def test_a_mass_behind_a_stinger_is_as_uncertain_as_its_stiffness(
    gauge: str, accelerometer: str
) -> None:
    """1/M_read = 1/M - w^2/k without damping: dM = w^2 M^2 (1/k - 1/k') for a stiffness k' that is
    believed. At the box nothing hangs on it but the gauge's own mass at the other end, M_g w^2/k of
    the box's: 1e-3 of that change."""
    w, k = 2 * np.pi * FREQUENCY, 5e6
    exciter = replace(EXCITER, stinger_damping=0.0)
    a = np.array([5.0 + 0j])
    pull = (LOAD + MASS * (gauge == "box")) * a
    other = a - w**2 * pull / k
    read = energy(
        pull + (MASS * other if gauge == "exciter" else 0.0),
        other if accelerometer == "exciter" else a,
    )
    found = at_box(read, gauge, accelerometer, MASS, exciter)
    behind = LOAD + MASS * (gauge == "box")
    change = 1 / (1 / behind - w**2 / k + w**2 / (1.05 * k)) - behind
    assert found.M_stiffness == pytest.approx(
        change if accelerometer == "exciter" else 0.0, rel=1e-9, abs=MASS * w**2 / k * 0.05 * LOAD
    )
