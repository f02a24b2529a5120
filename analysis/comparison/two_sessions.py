"""Comparison of two sessions: the same settings with another bed, another drive, or a simulation
beside a measurement.

W_B - W_A of conditions with equal settings, with U from both budgets. Instrument errors of a
session are common to its conditions; if both sessions used the same instruments they are common to
both, and only the difference of their sensitivities counts. Energies are not corrected to equal
levels: the difference of the levels counts as an uncertainty (rectangular).
"""

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

from analysis.results.comparison_rows import (
    SCHEMA,
    ComparedPair,
    ComparedSession,
    Comparison,
    OverallDifference,
    RankOrder,
    Unmatched,
)
from analysis.results.condition_row import ConditionRow
from analysis.results.report import Report
from analysis.uncertainty.budget import combine
from analysis.uncertainty.estimate import Estimate
from analysis.uncertainty.multiple_comparisons import holm

__all__ = ["FARTHEST", "MATCHED_BY", "compare", "kendall"]

SETTINGS = ("material", "density", "diameter", "fill", "frequency")
MATCHED_BY = (*SETTINGS, "acceleration")
NOT_STATED = "not stated"  # material in an imported session whose mapping names none
FARTHEST = 0.05  # largest difference of the levels reached, relative
EQUAL = 1e-6  # relative difference of settings that count as equal
FREQUENCY = 1e-3  # the same of frequencies: one of them may be estimated from a record
LEVEL = 0.05  # of the tests of all pairs together

Pair = tuple[ConditionRow, ConditionRow]
"""A condition of A and its match in B."""


def compare(
    a: Report, b: Report, same_instruments: bool = False, folders: tuple[str, str] = ("A", "B")
) -> Comparison:
    """Return the comparison of two reports: energies in J per cycle, `difference` B less A.

    same_instruments: instrument errors are common to both sessions. folders: names that distinguish
    two sessions of one protocol.
    """
    one_name = a.protocol == b.protocol
    pairs, alone = matched(a.conditions, b.conditions)
    rows = [_pair(first, second, same_instruments) for first, second in pairs]
    adjusted = holm([row.p for row in rows])
    return Comparison(
        schema=SCHEMA,
        sessions=(
            _session(a, folders[0] if one_name else ""),
            _session(b, folders[1] if one_name else ""),
        ),
        matched_by=MATCHED_BY,
        same_instruments=same_instruments,
        pairs=tuple(
            replace(row, p_holm=p, significant=p <= LEVEL)
            for row, p in zip(rows, adjusted, strict=True)
        ),
        alone=tuple(alone),
        overall=_overall(pairs, same_instruments),
        ranks=_ranks(pairs),
    )


def _session(report: Report, folder: str) -> ComparedSession:
    """Return the comparison's entry for a session; folder: added to the protocol's name."""
    rows, protocol = report.conditions, report.protocol
    return ComparedSession(
        name=f"{protocol} ({folder})" if protocol and folder else protocol or folder or "session",
        protocol=protocol,
        synthetic=report.synthetic,
        verdict=report.verdict,
        beds=tuple(sorted({row.bed for row in rows})),
        drives=tuple(sorted({row.drive for row in rows})),
        conditions=len(rows),
        ratio=report.agreement.ratio,
        U_ratio=report.agreement.U_ratio,
    )


def matched(
    a: Sequence[ConditionRow], b: Sequence[ConditionRow]
) -> tuple[list[Pair], list[Unmatched]]:
    """Return pairs of conditions with equal settings, and the conditions without a match with the
    reason.

    Levels of a pair differ by at most FARTHEST; each condition is used once. A setting that one
    side does not state counts as equal, but conditions that only such a setting would distinguish
    are not matched. The same bed takes precedence, then the same drive; the level that was set
    takes precedence over the nearest level that was reached.
    """
    alike = [(row, other) for row in a for other in b if not _differ(row, other)]
    found: dict[str, ConditionRow] = {}
    for places in (("bed", "drive"), ("bed",), ()):
        for set_alike in (True, False):
            used = {other.id for other in found.values()}
            free = [pair for pair in alike if pair[0].id not in found and pair[1].id not in used]
            found |= _nearest([pair for pair in free if _preferred(pair, places, set_alike)])
    pairs = [(row, found[row.id]) for row in a if row.id in found]
    used = {other.id for _, other in pairs}
    alone = [
        Unmatched(name, row.id, _why(row, others, to))
        for name, rows, others, to, taken in (
            ("A", a, b, "B", found.keys()),
            ("B", b, a, "A", used),
        )
        for row in rows
        if row.id not in taken
    ]
    return pairs, alone


def _preferred(pair: Pair, places: Sequence[str], set_alike: bool) -> bool:
    """Return whether a pair agrees in the fields `places` and, if asked, in the level that was set."""
    row, other = pair
    same = all(getattr(row, name) == getattr(other, name) for name in places)
    return same and (not set_alike or _equal(row.acceleration_set, other.acceleration_set))


def _nearest(links: Sequence[Pair]) -> dict[str, ConditionRow]:
    """Return conditions of B by ids of A, matched from possible pairs, nearest levels first.

    Only pairs whose rivals differ from them in the level alone.
    """
    others_of, rows_of = defaultdict(list), defaultdict(list)
    for row, other in links:
        others_of[row.id].append(other)
        rows_of[other.id].append(row)
    found: dict[str, ConditionRow] = {}
    used: set[str] = set()
    for row, other in sorted(links, key=lambda link: abs(_levels(*link))):
        unique = _differ_in_level_only(others_of[row.id]) and _differ_in_level_only(
            rows_of[other.id]
        )
        if unique and row.id not in found and other.id not in used:
            found[row.id] = other
            used.add(other.id)
    return found


def _differ_in_level_only(rows: Sequence[ConditionRow]) -> bool:
    """Return whether conditions of one session differ in the level that was set, and in nothing
    else.
    """
    return all(
        all(getattr(one, name) == getattr(other, name) for name in SETTINGS)
        and not _equal(one.acceleration_set, other.acceleration_set)
        for one, other in combinations(rows, 2)
    )


def _why(row: ConditionRow, others: Sequence[ConditionRow], to: str) -> str:
    """Return why a condition has no match in session `to`."""
    several = [other.id for other in others if not _differ(row, other)]
    if several:
        return f"ambiguous, or matched with a nearer level: {to} has {', '.join(several)}"
    if not others:
        return f"{to} has no condition"
    near = min(
        others,
        key=lambda other: (len(set(_differ(row, other)) & {*SETTINGS}), abs(_levels(row, other))),
    )
    fields = _differ(row, near)
    if fields == ["acceleration"]:
        return f"the levels reached are {100 * abs(_levels(row, near)):.2g} % apart ({near.id} of {to})"
    listed = ", ".join(f"{name} {_text(row, name)} against {_text(near, name)}" for name in fields)
    return f"no condition of {to} has these settings; nearest is {near.id}: {listed}"


def _text(row: ConditionRow, name: str) -> str:
    """Return a setting in words."""
    value: str | float = getattr(row, name)
    return value if isinstance(value, str) else f"{value:.6g}"


def _differ(one: ConditionRow, other: ConditionRow) -> list[str]:
    """Return the names of the settings that differ. Measured levels, which nobody set, are compared
    as reached.
    """
    names = []
    for name in SETTINGS:
        tolerance = FREQUENCY if name == "frequency" else EQUAL
        if not _equal(getattr(one, name), getattr(other, name), tolerance):
            names.append(name)
    was_set = "measured" not in (one.drive, other.drive)
    if was_set and not _equal(one.acceleration_set, other.acceleration_set, FARTHEST):
        names.append("acceleration_set")
    elif abs(_levels(one, other)) > FARTHEST:
        names.append("acceleration")
    return names


def _unknown(value: object) -> bool:
    """Return whether a setting is not stated."""
    return value is None or value == NOT_STATED


def _equal(one: str | float | None, other: str | float | None, tolerance: float = EQUAL) -> bool:
    """Return whether two settings agree within a relative tolerance; one that is not stated agrees
    with any.
    """
    if one is None or other is None or _unknown(one) or _unknown(other):
        return True
    if isinstance(one, str) or isinstance(other, str):
        return bool(one == other)
    return math.isclose(one, other, rel_tol=tolerance)


def _levels(a: ConditionRow, b: ConditionRow) -> float:
    """Return ln of the ratio of the levels reached, B over A."""
    return math.log(b.acceleration / a.acceleration) if a.acceleration and b.acceleration else 0.0


def _pair(a: ConditionRow, b: ConditionRow, same: bool) -> ComparedPair:
    """Return the comparison of one pair; `compare` decides afterwards which differences are
    significant.
    """
    difference = _estimate(b.W_exp - a.W_exp, [(a, -1.0)], [(b, 1.0)], same, [_level_part(a, b)])
    significant = all(row.W_exp > max(row.detected, row.U_W_exp) for row in (a, b))
    ratio = b.W_exp / a.W_exp if significant else None
    relative = None
    if ratio is not None:
        scale = 1 / a.W_exp
        relative = _estimate(
            ratio - 1, [(a, -ratio * scale)], [(b, scale)], same, [_level_part(a, b) * scale]
        )
    p = difference.p()
    return ComparedPair(
        A=a.id,
        B=b.id,
        material=b.material if _unknown(a.material) else a.material,
        density=b.density if a.density is None else a.density,
        diameter=b.diameter if a.diameter is None else a.diameter,
        fill=b.fill if a.fill is None else a.fill,
        frequency=b.frequency if a.frequency is None else a.frequency,
        acceleration_set=b.acceleration_set if a.acceleration_set is None else a.acceleration_set,
        not_compared=tuple(
            name for name in SETTINGS if _unknown(getattr(a, name)) or _unknown(getattr(b, name))
        ),
        bed_A=a.bed,
        bed_B=b.bed,
        acceleration_A=a.acceleration,
        acceleration_B=b.acceleration,
        W_A=a.W_exp,
        U_A=a.U_W_exp,
        W_B=b.W_exp,
        U_B=b.U_W_exp,
        difference=difference.value,
        U_difference=difference.U,
        E_n=difference.value / difference.U if difference.U else None,
        p=p,
        relative=None if relative is None else relative.value,
        U_relative=None if relative is None else relative.U,
        runs_A=len(a.runs),
        runs_B=len(b.runs),
        p_holm=p,
        significant=False,
    )


def _level_part(a: ConditionRow, b: ConditionRow) -> float:
    """Return the standard uncertainty of a difference, J, that unequal levels cause; W grows as
    a^n.
    """
    n = float(a.exponent or b.exponent or 2.0)
    return abs(n * _levels(a, b)) * max(abs(float(a.W_exp)), abs(float(b.W_exp))) / math.sqrt(3)


def _estimate(
    value: float,
    a: Sequence[tuple[ConditionRow, float]],
    b: Sequence[tuple[ConditionRow, float]],
    same: bool,
    more: Sequence[float] = (),
) -> Estimate:
    """Return a value with the uncertainty that follows from its derivatives to W of conditions of A
    and B.

    Budget lines in J (scatter, noise) are a condition's own. All others are one error of the
    session's instruments, of both sessions where `same`. more: further standard uncertainties.
    """
    shared: dict[tuple[str, str], float] = defaultdict(float)
    nu: dict[tuple[str, str], float] = {}
    parts = [(part, math.inf) for part in more]
    for name, weights in (("A", a), ("B", b)):
        for row, weight in weights:
            for line in row.uncertainty:
                part = weight * line.c * line.u
                dof = math.inf if line.nu is None else line.nu
                if line.unit == "J":
                    parts.append((part, dof))
                else:
                    key = ("" if same else name, line.source)
                    shared[key] += part
                    nu[key] = dof
    return combine(value, [*parts, *((part, nu[key]) for key, part in shared.items())])


def _overall(pairs: Sequence[Pair], same: bool) -> OverallDifference | None:
    """Return sum W_B / sum W_A - 1; None without a pair."""
    total = math.fsum(a.W_exp for a, _ in pairs)
    if not pairs or not total > 0:
        return None
    ratio = math.fsum(b.W_exp for _, b in pairs) / total
    levels = [_level_part(a, b) / total for a, b in pairs]
    found = _estimate(
        ratio - 1,
        [(a, -ratio / total) for a, _ in pairs],
        [(b, 1 / total) for _, b in pairs],
        same,
        levels,
    )
    nu = None if math.isinf(found.nu) else found.nu
    return OverallDifference(found.value, found.U, found.k, nu, len(pairs))


def kendall(x: Sequence[float], y: Sequence[float]) -> float | None:
    """Return Kendall's tau-b (Biometrika 33, 239 (1945)); None where one of the two does not vary."""
    signs = [(_sign(x[i] - x[j]), _sign(y[i] - y[j])) for i, j in combinations(range(len(x)), 2)]
    ups, downs = sum(s * s for s, _ in signs), sum(t * t for _, t in signs)
    return sum(s * t for s, t in signs) / math.sqrt(ups * downs) if ups and downs else None


def _sign(value: float) -> int:
    """Return -1, 0 or 1."""
    return (value > 0) - (value < 0)


def _ranks(pairs: Sequence[Pair]) -> RankOrder:
    """Return tau over the pairs with its 95 % interval, and the rank orders on which the sessions
    disagree.

    The interval is tanh(atanh(tau) ± 1.96 sqrt(0.437/(n - 4))), from 10 pairs on (Fieller, Hartley
    and Pearson, Biometrika 44, 470 (1957)).
    """
    tau = kendall([a.W_exp for a, _ in pairs], [b.W_exp for _, b in pairs])
    n, interval = len(pairs), None
    if tau is not None and n >= 10:
        z, half = (
            math.atanh(max(-1 + 1e-12, min(tau, 1 - 1e-12))),
            1.96 * math.sqrt(0.437 / (n - 4)),
        )
        interval = math.tanh(z - half), math.tanh(z + half)
    opposite, decided = 0, []
    for (a, b), (c, d) in combinations(pairs, 2):
        in_a, in_b = _order(a, c), _order(b, d)
        if (a.W_exp - c.W_exp) * (b.W_exp - d.W_exp) < 0:
            opposite += 1
            if in_a * in_b < 0:
                decided.append(f"{a.id} and {c.id}")
    return RankOrder(n, tau, interval, n * (n - 1) // 2, opposite, tuple(decided))


def _order(one: ConditionRow, other: ConditionRow) -> int:
    """Return which of two conditions of a session has the larger W: 1, -1, or 0 where the
    difference is within its U.
    """
    found = _estimate(one.W_exp - other.W_exp, [(one, 1.0), (other, -1.0)], (), True)
    return _sign(found.value) if abs(found.value) > found.U else 0
