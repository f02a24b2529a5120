"""Candidate causes of an excess of W_exp over W_T, and the marks that distinguish them.

Each cause has a closed form in acceleration, frequency and mass. Where the stand of the session had
the cause, the ledger's energies replace the closed form; elsewhere the form says how much energy
the cause would dissipate on this rig. The growth exponents are slopes of ln(energy) against
ln(acceleration, moving mass, fill), each fitted within conditions that differ in nothing else.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from analysis.results.condition import Result
from analysis.results.session_rows import CauseRow, Growth, Span
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
    """The operating point of a condition, SI units.

    M : moving mass: box, gauge side and bed, kg
    M_eff : apparent mass, kg
    W, W_T : measured and predicted energy, J per cycle
    n : exponent dlnW_T/dlna
    losses : coefficients of the box's losses, N s/m and N s^2/m^2
    kind : bed, material, density and diameter: equal in conditions that differ only in fill and
        level
    level : frequency (Hz) and acceleration that was set (m/s^2)
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
        """Angular frequency, rad/s."""
        return 2 * math.pi * self.frequency

    @property
    def X(self) -> float:
        """Stroke amplitude, m."""
        return self.acceleration / self.omega**2


Form = Callable[[OperatingPoint], float]


@dataclass(frozen=True)
class Cause:
    """A candidate cause of an excess.

    form : closed form, J per cycle; None where there is none
    column : the ledger column that holds its energy
    loss, support : the entries of the protocol that switch it on; "" for a cause that is always
        there
    """

    name: str
    law: str
    words: str
    form: Form | None
    column: str = ""
    loss: str = ""
    support: str = ""

    def listed(self, setting: Setting) -> bool:
        """Return whether the stand had this cause in a condition."""
        return self.loss in setting.losses and self.support in ("", setting.support)


def causes(
    results: Sequence[Result], channels: Mapping[str, ChannelFacts], assumed: Iterable[RigValue]
) -> tuple[CauseRow, ...]:
    """Return a row for each cause, after a row for the excess itself, W_exp - W_T.

    Empty without results or where the rig file lacks one of the values NEEDED. Numbers that the
    session cannot show are None.
    """
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
        # What the ledger observed takes the place of the closed form.
        ledger = {result.setting.id: result.ledger_mean(cause.column) for result in listed}
        energies |= {name: energy for name, energy in ledger.items() if energy is not None}
        in_run = bool(listed) or not cause.loss
        row = _row(cause, results, points, energies, cause.form or (lambda _still: 0.0), in_run)
        over = _over_first_principles(results, cause.loss)
        note = _gas_note(listed) if cause.name == "gas" else ""
        rows.append(replace(row, note=note, over_first_principles=over))
    return tuple(rows)


def _candidates(
    rig: Mapping[str, float], channels: Mapping[str, ChannelFacts]
) -> tuple[Cause, ...]:
    """Return the causes with their closed forms, for the values of a rig file by path."""
    force, acceleration = channels["force"], channels["acceleration"]

    # pi M_eff w^2 X^2 = (pi/w^2) M_eff a^2: J that an angle of 1 rad between the channels adds to W.
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
    """Return the operating point of a condition, from means over its runs."""
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
    """Return the report's row of a cause.

    energies: of the cause by condition, J per cycle; form: closed form for the beds that were not
    measured; in_run: the stand had the cause, so that `energies` were observed and not computed.
    """
    known = [(points[name], energy) for name, energy in energies.items()]
    predicted = [(point, energy) for point, energy in known if point.W_T > 0]
    total = math.fsum(point.W_T for point, _ in predicted)
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
        share=math.fsum(energy for _, energy in predicted) / total if total else None,
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
    """Return the energy in the empty box (bed: with a locked bed) as a fraction of W_T, and its
    source.

    Energies are summed over the levels, and so are the largest W_T of each level. They are taken
    from the session ("run") where it has such conditions, otherwise from the closed form
    ("computed"). (None, None) where neither is there.
    """
    # Of each level the condition with the largest W_T, and the heaviest one without sliding grains.
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
    """Return the operating point of the same box with its grains removed or bonded to it."""
    point = points[result.setting.id]
    M = point.M if bed else point.M - result.setting.bed_mass
    return replace(point, M=M, M_eff=M, W=0.0, W_T=0.0)


def _slope(cases: Iterable[tuple[float, float, Any]]) -> float | None:
    """Return the common slope of ln y against ln x of entries (x, y, group), each group with its
    own level.

    None where x does not vary within any group.
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
    # x that varies by less than 0.1 % gives no slope: (1e-3)^2, of ln x.
    return product / square if square > 1e-6 else None


def _over_first_principles(results: Iterable[Result], loss: str) -> Span | None:
    """Return the least and the largest ratio of a loss's coefficient to its value by first
    principles.

    None where no condition states it.
    """
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
    """Return where gas drag was switched on, and the range of its largest drag over the bed's
    weight.
    """
    found = [facts for facts in (result.setting.gas for result in listed) if facts is not None]
    if not found:
        return "not listed in this run"
    percent = [100 * float(facts.share_of_weight) for facts in found]
    on = sum(facts.on for facts in found)
    if not on:
        state = "off"
    elif on == len(found):
        state = "on"
    else:
        state = f"on in {on} of {len(found)} conditions"
    return f"{state}, {min(percent):.2g} % to {max(percent):.2g} % of the bed's weight"
