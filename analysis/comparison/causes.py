"""What could make W_exp exceed W_T, and what distinguishes the candidates.

Each cause has a closed form in acceleration, frequency and mass. Where a run holds the cause, the
ledger's energies take the form's place; where it does not, the form says what it would do on this
rig. Growth is the slope of ln(energy) against ln(acceleration, moving mass, fill), fitted within
conditions that differ in nothing else.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from analysis.results.cause_row import CauseRow, Growth, Span
from analysis.results.condition import Result
from analysis.session.protocol import RigValue
from analysis.session.record import ChannelFacts
from analysis.session.setting import NoiseAndAir, Setting
from analysis.uncertainty.budget import angle_uncertainty, certificate_lines

__all__ = ["causes"]

NEEDED = (
    "guide_friction",
    "gravity",
    "cord_frequency",
    "cord_loss_factor",
)
LOSSES = ("loss_noise", "loss_air")
"""Coefficients that a rig file may leave to first principles; the conditions then have them."""
NO_LOSSES = NoiseAndAir(0.0, 0.0)
SCALES = {"force sensitivity", "acceleration sensitivity", "force gain", "acceleration gain"}


@dataclass(frozen=True)
class OperatingPoint:
    """A box at work. SI; M: box, gauge side and bed, kg; M_eff: apparent mass; W, W_T: J per cycle;
    n = dlnW_T/dlna; losses: coefficients of the box's losses, N s/m and N s^2/m^2.
    """

    acceleration: float
    frequency: float
    M: float
    M_eff: float
    W: float = 0.0
    W_T: float = 0.0
    n: float = 0.0
    fill: float = 0.0
    kind: tuple[Any, ...] = ()
    level: tuple[float, float] = (0.0, 0.0)
    losses: NoiseAndAir = NO_LOSSES

    @property
    def omega(self) -> float:
        return 2 * math.pi * self.frequency

    @property
    def X(self) -> float:
        """Stroke amplitude, m."""
        return self.acceleration / self.omega**2


Form = Callable[[OperatingPoint], float]


@dataclass(frozen=True)
class Cause:
    """A candidate: closed form (J per cycle, None where there is none), ledger column and what has
    to be listed.
    """

    name: str
    law: str
    words: str
    form: Form | None
    column: str = ""
    loss: str = ""
    support: str = ""

    def listed(self, setting: Setting) -> bool:
        """Whether the stand had this cause in a condition."""
        return self.loss in setting.losses and self.support in ("", setting.support)


def causes(
    results: Sequence[Result], channels: Mapping[str, ChannelFacts], assumed: Iterable[RigValue]
) -> tuple[CauseRow, ...]:
    """A row per cause, first what is to be explained: W_exp - W_T. Empty without results or without
    a rig's values. Numbers are None where the run cannot tell."""
    rig = {
        value.path: value.value
        for value in assumed
        if value.path in (*NEEDED, *LOSSES) and isinstance(value.value, float | int)
    }
    known = all(name in rig for name in LOSSES) or all(r.setting.loss_coefficients for r in results)
    if not results or not known or any(name not in rig for name in NEEDED):
        return ()
    points = {result.setting.id: _point(result, rig) for result in results}
    rows = [
        _row(
            Cause("measured excess", "W_exp - W_T", "What has to be explained.", None),
            results,
            points,
            {name: point.W - point.W_T for name, point in points.items()},
            None,
            True,
        )
    ]
    for cause in _candidates({name: float(rig[name]) for name in NEEDED}, channels):
        listed = [result for result in results if cause.listed(result.setting)]
        energies = {name: cause.form(point) for name, point in points.items()} if cause.form else {}
        seen = {result.setting.id: _mean(result, cause.column) for result in listed}
        energies |= {name: energy for name, energy in seen.items() if energy is not None}
        in_run = bool(listed) or not cause.loss
        row = _row(cause, results, points, energies, cause.form or (lambda _still: 0.0), in_run)
        over = _over_first_principles(results, cause.loss)
        note = _gas_note(listed) if cause.name == "gas" else ""
        rows.append(replace(row, note=note, over_first_principles=over))
    return tuple(rows)


def _candidates(
    rig: Mapping[str, float], channels: Mapping[str, ChannelFacts]
) -> tuple[Cause, ...]:
    force, acceleration = channels["force"], channels["acceleration"]

    def phase(p: OperatingPoint) -> float:
        return (
            math.pi
            * p.M_eff
            * p.omega**2
            * p.X**2
            * angle_uncertainty(force, acceleration, p.frequency).U
        )

    def scale(p: OperatingPoint) -> float:
        lines = certificate_lines(force, acceleration, p.frequency, p.W, 0.0, p.W_T, p.n)
        return 2 * math.sqrt(
            math.fsum((line.part - line.part_T) ** 2 for line in lines if line.source in SCALES)
        )

    def cords(p: OperatingPoint) -> float:
        return (
            math.pi
            * rig["cord_loss_factor"]
            * p.M
            * (2 * math.pi * rig["cord_frequency"]) ** 2
            * p.X**2
        )

    return (
        Cause(
            "noise",
            "pi c w X^2",
            "Grows as a squared and knows no mass: the empty box keeps all of it, and it "
            "weighs most where the bed takes least.",
            lambda p: math.pi * p.losses.noise * p.omega * p.X**2,
            "W_noise",
            "noise",
        ),
        Cause(
            "air",
            "8/3 k w^2 X^3",
            "Grows as a cubed and knows no mass: the empty box keeps all of it.",
            lambda p: 8 / 3 * p.losses.air * p.omega**2 * p.X**3,
            "W_air",
            "air",
        ),
        Cause(
            "gas",
            "Ergun on the bed's slip",
            "Needs slip: nothing is left of it where nothing slides.",
            None,
            "W_gas",
            "gas",
        ),
        Cause(
            "guide friction",
            "4 mu M g X",
            "Grows with a and with the moving weight: little in the empty box, "
            "most in the heaviest.",
            lambda p: 4 * rig["guide_friction"] * p.M * rig["gravity"] * p.X,
            "W_mount",
            "mount",
            "guide",
        ),
        Cause(
            "cords",
            "pi eta k X^2",
            "Grows as a squared and with the mass that the cords are chosen for.",
            cords,
            "W_mount",
            "mount",
            "cords",
        ),
        Cause(
            "sensor phase",
            "(pi/w^2) M_eff a^2 U(angle)",
            "Grows as a squared and with the apparent mass: a locked "
            "bed shows it. As large as the certificates allow.",
            phase,
        ),
        Cause(
            "scale",
            "U(sensitivities, gains)",
            "In proportion to W, the level's part as 1 - n: gone where nothing "
            "is dissipated. As large as the certificates allow.",
            scale,
        ),
    )


def _point(result: Result, rig: Mapping[str, float | int]) -> OperatingPoint:
    s = result.setting
    losses = s.loss_coefficients or NoiseAndAir(*(float(rig[name]) for name in LOSSES))
    M = s.box_mass + s.gauge_mass + s.bed_mass
    W_T = result.W_T.value if result.W_T else 0.0
    exponent = result.predicted.exponent or 0.0
    return OperatingPoint(
        result.mean("level"),
        s.frequency,
        M,
        result.mean("M_eff"),
        result.W_exp.value,
        W_T,
        exponent,
        s.fill or 0.0,
        (s.bed, s.material, s.density, s.diameter),
        (s.frequency, s.acceleration_set),
        losses,
    )


def _row(
    cause: Cause,
    results: Sequence[Result],
    points: Mapping[str, OperatingPoint],
    energies: Mapping[str, float],
    form: Form | None,
    in_run: bool,
) -> CauseRow:
    known = [(points[name], energy) for name, energy in energies.items()]
    told = [(point, energy) for point, energy in known if point.W_T > 0]
    total = math.fsum(point.W_T for point, _ in told)
    empty, empty_from = _left(results, points, energies, form, False)
    locked, locked_from = _left(results, points, energies, form, True)
    if not in_run:
        empty_from = empty_from and "computed"
        locked_from = locked_from and "computed"
    return CauseRow(
        cause=cause.name,
        law=cause.law,
        words=cause.words,
        in_run=in_run,
        grows_with=Growth(
            acceleration=_slope(
                [(p.acceleration, e, (p.kind, p.fill, p.frequency)) for p, e in known]
            ),
            mass=_slope([(p.M, e, p.level) for p, e in known]),
            fill=_slope([(p.fill, e, (p.kind, p.level)) for p, e in known]),
        ),
        share=math.fsum(energy for _, energy in told) / total if total else None,
        empty=empty,
        empty_from=empty_from,
        locked=locked,
        locked_from=locked_from,
        over_first_principles=None,
        note="",
    )


def _left(
    results: Sequence[Result],
    points: Mapping[str, OperatingPoint],
    energies: Mapping[str, float],
    form: Form | None,
    bed: bool,
) -> tuple[float | None, str | None]:
    """Energy in the empty box (bed: with a locked bed) over the largest W_T at the same level,
    summed over the levels; from such conditions of the run where there are any, else by the closed
    form."""
    fullest: dict[tuple[float, float], Result] = {}
    still: dict[tuple[float, float], str] = {}
    for result in results:
        name, setting = result.setting.id, result.setting
        level = points[name].level
        if level not in fullest or points[name].W_T > points[fullest[level].setting.id].W_T:
            fullest[level] = result
        fits = name in energies and (setting.is_bonded if bed else setting.is_empty)
        if fits and (level not in still or points[name].M > points[still[level]].M):
            still[level] = name
    levels = [level for level, result in fullest.items() if points[result.setting.id].W_T > 0]
    of_run = [level for level in levels if level in still]
    if of_run:
        found, source = [(energies[still[level]], level) for level in of_run], "run"
    elif form is not None:
        found, source = (
            [(form(_still(fullest[level], points, bed)), level) for level in levels],
            "computed",
        )
    else:
        return None, None
    total = math.fsum(points[fullest[level].setting.id].W_T for _, level in found)
    return (math.fsum(energy for energy, _ in found) / total, source) if total else (None, None)


def _still(result: Result, points: Mapping[str, OperatingPoint], bed: bool) -> OperatingPoint:
    """The same box, its grains taken out or bonded to it: nothing but mass."""
    point = points[result.setting.id]
    M = point.M if bed else point.M - result.setting.bed_mass
    return replace(point, M=M, M_eff=M, W=0.0, W_T=0.0)


def _slope(cases: Iterable[tuple[float, float, Any]]) -> float | None:
    """Common slope of ln y against ln x of (x, y, group), each group with a level of its own; None
    where x stands.
    """
    groups: dict[Any, list[tuple[float, float]]] = {}
    for x, y, group in cases:
        if x > 0 and y > 0:
            groups.setdefault(group, []).append((math.log(x), math.log(y)))
    square = product = 0.0
    for pairs in groups.values():
        middle = [math.fsum(values) / len(pairs) for values in zip(*pairs, strict=True)]
        square += math.fsum((x - middle[0]) ** 2 for x, _ in pairs)
        product += math.fsum((x - middle[0]) * (y - middle[1]) for x, y in pairs)
    return product / square if square > 1e-6 else None


def _mean(result: Result, column: str) -> float | None:
    """Mean of a ledger column over the runs, J per cycle; None without truth."""
    values = [
        run.ledger[column] for run in result.runs if run.ledger is not None and column in run.ledger
    ]
    return math.fsum(values) / len(values) if len(values) == len(result.runs) else None


def _over_first_principles(results: Iterable[Result], loss: str) -> Span | None:
    """Least and largest of a loss's coefficient over its size by first principles."""
    known = [
        facts
        for facts in (result.setting.over_first_principles for result in results)
        if facts is not None
    ]
    found = [
        value for value in (getattr(facts, loss, None) for facts in known) if value is not None
    ]
    return Span(float(min(found)), float(max(found))) if found else None


def _gas_note(listed: Sequence[Result]) -> str:
    """Where the gas was switched on, and its largest drag over the bed's weight."""
    found = [facts for facts in (result.setting.gas for result in listed) if facts is not None]
    if not found:
        return "not listed in this run"
    shares = [100 * float(facts.share_of_weight) for facts in found]
    on = sum(facts.on for facts in found)
    state = (
        "off" if not on else "on" if on == len(found) else f"on in {on} of {len(found)} conditions"
    )
    return f"{state}, {min(shares):.2g} % to {max(shares):.2g} % of the bed's weight"
