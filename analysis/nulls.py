"""Null tests as angles: a bed that cannot slide must look like mass, whatever the box's own losses are.

W_lock - W_empty at equal acceleration holds no loss of the box (it is in both). What is left grows as a^2 where the two
channels are out of phase by dphi, (pi/w^2) dM a^2 dphi, and as a where something rubs under the bed's weight. So
W_lock - W_empty = alpha a^2 + beta a is fitted and dphi = w^2 alpha / (pi dM). At least three levels are needed: two
would be fitted exactly.
"""

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from analysis.estimate import Estimate
from analysis.family import FAILS, Tested
from analysis.runs import ChannelFacts, RunEnergy, Setting
from analysis.uncertainty import ANGLE_RESOLUTION, angle_uncertainty, certificate_lines, combine

__all__ = ["Null", "null_tests"]

LEVELS = 3
ROUNDS = 5  # of fit and law of variance in turn


@dataclass(frozen=True, slots=True)
class Null:
    """A null test: "locked" or "carried" bed, or "loop-back" (analysis.loop_back); levels: of the drive, of a loop-back
    its runs; dphi in rad, None without a fit; gain: of a loop-back, relative. verdict: holds within U, undecided
    beyond, until the family of all tests says that it does not hold (judged); tested: what it puts into that family."""

    null: str
    bed_mass: float
    frequency: float
    levels: int
    dphi: Estimate | None
    verdict: str
    why: str
    gain: Estimate | None = None
    tested: tuple[Tested, ...] = ()

    def judged(self, limit: float) -> "Null":
        """The same, that does not hold where a score is beyond the family's critical one."""
        return replace(self, verdict=FAILS) if any(test.score > limit for test in self.tested) else self

    def row(self) -> dict[str, Any]:
        """The report's entry."""
        return {
            "null": self.null,
            "bed_mass": self.bed_mass,
            "frequency": self.frequency,
            "levels": self.levels,
            "dphi": self.dphi.value if self.dphi else None,
            "U_dphi": self.dphi.U if self.dphi else None,
            "k": self.dphi.k if self.dphi else None,
            "nu": self.dphi.nu if self.dphi else None,
            "gain": self.gain.value if self.gain else None,
            "U_gain": self.gain.U if self.gain else None,
            "verdict": self.verdict,
            "why": self.why,
        }


def null_tests(
    settings: Mapping[str, Setting], runs: Mapping[str, Sequence[RunEnergy]], channels: Mapping[str, ChannelFacts]
) -> tuple[Null, ...]:
    """All null tests that the conditions allow: one per bed that cannot slide, bed mass, frequency and place of the
    instruments.

    settings, runs: by condition. Empty where no condition has a bed that cannot slide.
    """
    empty: dict[tuple[Any, ...], list[RunEnergy]] = defaultdict(list)
    bonded: dict[tuple[Any, ...], list[str]] = defaultdict(list)
    for name, setting in settings.items():
        if setting.is_empty:
            empty[setting.frequency, *setting.places].extend(runs.get(name, ()))
        elif setting.is_bonded and runs.get(name):
            kind = "locked" if setting.bed == "locked" else "carried"
            bonded[kind, setting.bed_mass, setting.frequency, *setting.places].append(name)
    return tuple(
        _test(kind, at[0], mass, [list(runs[name]) for name in names], empty[tuple(at)], channels)
        for (kind, mass, *at), names in bonded.items()
    )


def _test(
    kind: str,
    frequency: float,
    mass: float,
    levels: list[list[RunEnergy]],
    empty: list[RunEnergy],
    channels: Mapping[str, ChannelFacts],
) -> Null:
    found = min(len(levels), len({run.condition for run in empty}))
    if found < LEVELS:
        measured = f"only {found} level{'s' * (found > 1)} with this bed and with the empty box"
        why = (
            f"{measured if found else 'the empty box was not measured beside it'}: "
            f"at least {LEVELS} levels of both are needed to tell an angle from friction"
        )
        return Null(kind, mass, frequency, len(levels), None, "undecided", why)
    alpha = _growth([run for runs in levels for run in runs], empty)
    scale = (2 * math.pi * frequency) ** 2 / (math.pi * mass)
    certified = angle_uncertainty(channels["force"], channels["acceleration"], frequency)
    dphi = combine(alpha.value * scale, [(alpha.u * scale, alpha.nu), (certified.u, certified.nu)])
    holds = abs(dphi.value) <= dphi.U
    side = "within" if holds else "beyond"
    why = f"|angle| = {abs(dphi.value):.2g} rad is {side} U = {dphi.U:.2g} rad (k = {dphi.k:.2f})"
    shared = {
        line.source: line.part
        for line in certificate_lines(channels["force"], channels["acceleration"], frequency, 0.0, 1.0)
    }
    verdict = "holds" if holds else "undecided"
    return Null(kind, mass, frequency, len(levels), dphi, verdict, why, tested=(Tested(dphi, shared),))


def _growth(bonded: list[RunEnergy], empty: list[RunEnergy]) -> Estimate:
    """alpha (J s^4/m^2) in W_bonded - W_empty = alpha a^2 + beta a.

    One least-squares fit to all runs of W / a. The box's own losses, in both, follow r a + p a^2 + q a^3 (rubbing,
    viscous, quadratic): no two runs need the same level. The noise of W / a is not even: to the instruments' noise
    comes a scatter that grows with W. Runs are weighted by that law of variance, its share of W taken from the
    residuals and its scale from how they then scatter: one scatter behind all runs, with the degrees of freedom of all.
    """
    runs = [*empty, *bonded]
    a = np.array([run.energy.level for run in runs])
    top = float(a.max())
    x = a / top
    with_bed = np.array([0.0] * len(empty) + [1.0] * len(bonded))
    design = np.stack([np.ones_like(x), x, x * x, with_bed, with_bed * x], axis=1)
    z = np.array([run.energy.W for run in runs]) / a
    dof = len(runs) - design.shape[1]
    own = np.array([run.u_noise**2 + (ANGLE_RESOLUTION * run.energy.reactive) ** 2 for run in runs])
    share = 0.0  # variance of W over its square, beside the instruments' noise
    variance = np.ones_like(a)
    for _ in range(ROUNDS):
        weight = 1 / np.sqrt(variance)
        to_z = np.linalg.pinv(design * weight[:, None]) * weight
        solution = to_z @ z
        residual, W = z - design @ solution, design @ solution * a
        beyond = (residual * a) ** 2 * len(runs) / dof - own
        trust = (W / (own + share * W**2)) ** 2  # a square scatters as its own expectation
        share = max(0.0, float(trust @ beyond) / float(trust @ W**2))
        variance = (own + share * W**2) / a**2
    scale = float((residual * weight) @ (residual * weight)) / dof
    u = float(np.linalg.norm(to_z[4] / weight)) * math.sqrt(scale)
    return Estimate(float(solution[4]) / top, u / top, float(dof))
