"""Null tests as angles: a bed that cannot slide must look like mass, whatever the box's own losses
are.

A phase error dphi between the channels adds (pi/w^2) M a^2 dphi to W, M the moving mass; friction
under that mass adds a term in M times the path length. The box's own losses do not depend on M:
rubbing is proportional to the path, viscous loss to the mean of v^2, quadratic loss to that of
|v|^3. So all runs with the bed and of the empty box form one linear regression, each run with the
motion and the mass that it measured itself: fillings differ by 1 % in mass, and the harmonics of
the drive change the losses of the box by more than the noise. At least three levels of both are
needed: two would be fitted exactly.
"""

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from analysis.comparison.family_of_tests import FAILS, Zero
from analysis.energy.energy_and_phasors import Energy
from analysis.results.judged_rows import NullRow
from analysis.results.run import RunEnergy
from analysis.session.record import ChannelFacts
from analysis.session.setting import Setting
from analysis.uncertainty.budget import (
    ANGLE_RESOLUTION,
    angle_uncertainty,
    certificate_lines,
    combine,
)
from analysis.uncertainty.estimate import Estimate
from analysis.uncertainty.partly_known_scatter import coefficient

__all__ = ["NullTest", "null_tests"]

LEVELS = 3  # fewest of the bed and of the empty box
THROUGH_STINGER = "the acceleration is read at the stinger's other end: what the stinger loses looks like an angle"
POINTS = 4096
"""Points of a cycle: a turning point between two of them is missed by at most (pi/4096)^2/2 = 3e-7 of
the amplitude."""
MIXTURES = (0.0, 0.5, 0.9, 1.0)
"""Fractions of the further variance that grow with W^2; the rest grows with a^2."""


@dataclass(frozen=True, slots=True)
class NullTest:
    """A null test: "locked" or "carried" bed, or "loop-back" (analysis.comparison.loop_back).

    levels : number of drive levels; of a loop-back, number of runs
    dphi : angle, rad; None without a fit
    gain : of a loop-back, relative
    verdict : holds within U, undecided beyond it, until `judged` compares it with the whole family
    tested : the quantities that it adds to the family of tests
    """

    null: str
    bed_mass: float
    frequency: float
    levels: int
    dphi: Estimate | None
    verdict: str
    why: str
    gain: Estimate | None = None
    tested: tuple[Zero, ...] = ()

    def judged(self, limit: float) -> "NullTest":
        """Return the null test with the verdict "does not hold" where a score exceeds the critical
        one, `limit`.
        """
        return (
            replace(self, verdict=FAILS)
            if any(test.score > limit for test in self.tested)
            else self
        )

    def row(self) -> NullRow:
        """Return the report's entry."""
        return NullRow(
            null=self.null,
            bed_mass=self.bed_mass,
            frequency=self.frequency,
            levels=self.levels,
            dphi=self.dphi.value if self.dphi else None,
            U_dphi=self.dphi.U if self.dphi else None,
            k=self.dphi.k if self.dphi else None,
            nu=self.dphi.nu if self.dphi else None,
            gain=self.gain.value if self.gain else None,
            U_gain=self.gain.U if self.gain else None,
            verdict=self.verdict,
            why=self.why,
        )


def null_tests(
    settings: Mapping[str, Setting],
    runs: Mapping[str, Sequence[RunEnergy]],
    channels: Mapping[str, ChannelFacts],
) -> tuple[NullTest, ...]:
    """Return all null tests that the conditions allow.

    There is one for each bed that cannot slide, bed mass, frequency and position of the
    instruments. settings, runs: by condition. Empty where no condition has a bed that cannot slide.
    None is decided where the acceleration is read through the stinger: the loss of a stinger is
    proportional to the square of the force, which grows with the mass as the effect of an angle
    does.
    """
    empty: dict[tuple[Any, ...], list[RunEnergy]] = defaultdict(list)
    bonded: dict[tuple[Any, ...], list[str]] = defaultdict(list)
    for name, setting in settings.items():
        if setting.is_empty:
            empty[setting.frequency, *setting.places].extend(runs.get(name, ()))
        elif setting.is_bonded and runs.get(name):
            kind = "locked" if setting.bed == "locked" else "carried"
            bonded[kind, setting.bed_mass, setting.frequency, *setting.places].append(name)
    found = []
    for (kind, mass, frequency, *places), names in bonded.items():
        if settings[names[0]].through_stinger:
            null = NullTest(kind, mass, frequency, len(names), None, "undecided", THROUGH_STINGER)
        else:
            levels = [list(runs[name]) for name in names]
            null = _test(kind, frequency, mass, levels, empty[frequency, *places], channels)
        found.append(null)
    return tuple(found)


def _test(
    kind: str,
    frequency: float,
    mass: float,
    levels: list[list[RunEnergy]],
    empty: list[RunEnergy],
    channels: Mapping[str, ChannelFacts],
) -> NullTest:
    """Return one null test; undecided where there are fewer than LEVELS levels of the bed or of the
    empty box.
    """
    found = min(len(levels), len({run.condition for run in empty}))
    if found < LEVELS:
        measured = f"only {found} level{'s' * (found > 1)} with this bed and with the empty box"
        why = (
            f"{measured if found else 'the empty box was not measured beside it'}: "
            f"at least {LEVELS} levels of both are needed to distinguish an angle from friction"
        )
        return NullTest(kind, mass, frequency, len(levels), None, "undecided", why)
    angle = _angle([run for runs in levels for run in runs] + empty)
    certified = angle_uncertainty(channels["force"], channels["acceleration"], frequency)
    dphi = combine(angle.value, [*angle.parts(), (certified.u, certified.nu)])
    holds = abs(dphi.value) <= dphi.U
    side = "within" if holds else "beyond"
    why = f"|angle| = {abs(dphi.value):.2g} rad is {side} U = {dphi.U:.2g} rad (k = {dphi.k:.2f})"
    shared = {
        line.source: line.part
        for line in certificate_lines(
            channels["force"], channels["acceleration"], frequency, 0.0, 1.0
        )
    }
    verdict = "holds" if holds else "undecided"
    return NullTest(
        kind, mass, frequency, len(levels), dphi, verdict, why, tested=(Zero(dphi, shared),)
    )


def _angle(runs: list[RunEnergy]) -> Estimate:
    """Return dphi (rad) of all runs, fitted with the coefficients of friction and of the box's
    losses.

    W = dphi (pi/w^2) M a^2 + f M path + r path + p int v^2 dt + q int |v|^3 dt. The runs scatter by
    the instruments' noise and by a further variance, which may grow with the level, with W, or in
    between.
    """
    energies = [run.energy for run in runs]
    W, a, M, reactive = (
        np.array([getattr(energy, name) for energy in energies])
        for name in ("W", "level", "M_eff", "reactive")
    )
    path, square, cube = np.array([_motion(energy) for energy in energies]).T
    noise = np.array([run.u_noise for run in runs])
    even, proportional = a**2 / np.mean(a**2), W**2 / np.mean(W**2)
    return coefficient(
        np.stack([reactive, M * path, path, square, cube], axis=1),
        W,
        noise**2 + (ANGLE_RESOLUTION * reactive) ** 2,
        [(1 - mixed) * even + mixed * proportional for mixed in MIXTURES],
        0,
    )


def _motion(energy: Energy) -> tuple[float, float, float]:
    """Return the path of the box in a cycle (m) and the integrals of v^2 (m^2/s) and |v|^3
    (m^3/s^2) over it, from the measured harmonics.
    """
    most = min(energy.acceleration.size, POINTS // 2 - 1)
    omega = 2j * math.pi * energy.frequency * np.arange(1, most + 1)
    lines = np.zeros((2, POINTS // 2 + 1), dtype=complex)
    lines[0, 1 : most + 1] = energy.acceleration[:most] / omega**2
    lines[1, 1 : most + 1] = energy.acceleration[:most] / omega
    position, velocity = np.fft.irfft(lines * (POINTS / 2), POINTS)
    path = np.abs(np.diff(position, append=position[0])).sum()
    speed = np.abs(velocity)
    return (
        float(path),
        float((speed**2).mean() / energy.frequency),
        float((speed**3).mean() / energy.frequency),
    )
