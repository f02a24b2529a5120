"""Two sessions compared: the same settings with another bed, another drive, or a simulation beside a measurement.

W_B - W_A of conditions with equal settings, with U from both budgets. What the instruments of a session do wrong is
common to its conditions; where both sessions used the same instruments it is common to both, and only the difference of
their sensitivities counts. Levels are not corrected: what they differ by counts as an uncertainty (rectangular).
"""

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

from analysis.estimate import Estimate
from analysis.multiple import holm
from analysis.uncertainty import combine

__all__ = ["FARTHEST", "MATCHED_BY", "compare", "kendall"]

SCHEMA = "rig/comparison/1"
MATCHED_BY = ("material", "density", "diameter", "fill", "frequency", "acceleration_set")
FARTHEST = 0.05  # largest difference of the levels reached, relative
EQUAL = 1e-6  # settings that agree so far are one
LEVEL = 0.05

Row = Mapping[str, Any]


def compare(a: Row, b: Row, same_instruments: bool = False) -> dict[str, Any]:
    """The comparison of two reports (report.json) as a plain dict; energies in J per cycle, `difference` B less A.

    same_instruments: their errors are common to both sessions.
    """
    pairs, alone = matched(a["conditions"], b["conditions"])
    rows = [_pair(first, second, same_instruments) for first, second in pairs]
    adjusted = holm([row["p"] for row in rows])
    for row, p in zip(rows, adjusted, strict=True):
        row["p_holm"], row["significant"] = p, p <= LEVEL
    return {
        "schema": SCHEMA,
        "sessions": [_session(a), _session(b)],
        "matched_by": list(MATCHED_BY),
        "same_instruments": same_instruments,
        "pairs": rows,
        "alone": alone,
        "overall": _overall(pairs, same_instruments),
        "ranks": _ranks(pairs),
    }


def _session(report: Row) -> dict[str, Any]:
    rows = report["conditions"]
    return {
        "protocol": report["protocol"], "synthetic": report["synthetic"], "verdict": report["verdict"],
        "beds": sorted({row["bed"] for row in rows}), "drives": sorted({row["drive"] for row in rows}),
        "conditions": len(rows), "ratio": report["agreement"]["ratio"], "U_ratio": report["agreement"]["U_ratio"],
    }  # fmt: skip


def matched(a: Sequence[Row], b: Sequence[Row]) -> tuple[list[tuple[Row, Row]], list[dict[str, str]]]:
    """Pairs of conditions with equal settings (what one of them does not know is no difference), and the others with
    the reason. Where settings come several times, the same bed goes first, then the same drive."""
    found: dict[str, Row] = {}
    for names in ((*MATCHED_BY, "bed", "drive"), (*MATCHED_BY, "bed"), MATCHED_BY):
        left = [row for row in a if row["id"] not in found]
        free = [row for row in b if row["id"] not in {other["id"] for other in found.values()}]
        for row in left:
            mine, rivals = _same(row, free, names), _same(row, left, names)
            if len(mine) == len(rivals) == 1:
                found[row["id"]] = mine[0]
    pairs, alone = [], []
    for row in a:
        other = found.get(row["id"])
        if other is None:
            several = ", ".join(each["id"] for each in _same(row, b, MATCHED_BY))
            why = f"not told apart: B has {several}" if several else "no condition of B has these settings"
            alone.append({"session": "A", "id": row["id"], "why": why})
        elif abs(_levels(row, other)) > FARTHEST:
            why = f"the levels reached are {100 * abs(_levels(row, other)):.2g} % apart ({other['id']} of B)"
            alone.append({"session": "A", "id": row["id"], "why": why})
        else:
            pairs.append((row, other))
    used = {other["id"] for _, other in pairs}
    why = "no condition of A was matched with it"
    alone += [{"session": "B", "id": row["id"], "why": why} for row in b if row["id"] not in used]
    return pairs, alone


def _same(row: Row, others: Sequence[Row], names: Sequence[str]) -> list[Row]:
    return [other for other in others if all(_equal(row[name], other[name]) for name in names)]


def _equal(one: Any, other: Any) -> bool:
    if one is None or other is None:
        return True
    if isinstance(one, str) or isinstance(other, str):
        return bool(one == other)
    return math.isclose(one, other, rel_tol=EQUAL)


def _levels(a: Row, b: Row) -> float:
    """ln of the ratio of the levels reached."""
    return math.log(b["acceleration"] / a["acceleration"]) if a["acceleration"] and b["acceleration"] else 0.0


def _pair(a: Row, b: Row, same: bool) -> dict[str, Any]:
    difference = _estimate(b["W_exp"] - a["W_exp"], [(a, -1.0)], [(b, 1.0)], same, [_level_part(a, b)])
    told = all(row["W_exp"] > max(row["W_detect"], row["U_W_exp"]) for row in (a, b))
    ratio = b["W_exp"] / a["W_exp"] if told else None
    relative = None
    if ratio is not None:
        scale = 1 / a["W_exp"]
        relative = _estimate(ratio - 1, [(a, -ratio * scale)], [(b, scale)], same, [_level_part(a, b) * scale])
    return {
        "A": a["id"], "B": b["id"], **{name: a[name] if a[name] is not None else b[name] for name in MATCHED_BY},
        "bed_A": a["bed"], "bed_B": b["bed"], "acceleration_A": a["acceleration"], "acceleration_B": b["acceleration"],
        "W_A": a["W_exp"], "U_A": a["U_W_exp"], "W_B": b["W_exp"], "U_B": b["U_W_exp"],
        "difference": difference.value, "U_difference": difference.U,
        "E_n": difference.value / difference.U if difference.U else None, "p": difference.p(),
        "relative": None if relative is None else relative.value,
        "U_relative": None if relative is None else relative.U,
    }  # fmt: skip


def _level_part(a: Row, b: Row) -> float:
    """Standard uncertainty of a difference in J from levels that are not the same, W growing as a^n."""
    n = float(a.get("exponent") or b.get("exponent") or 2.0)
    return abs(n * _levels(a, b)) * max(abs(float(a["W_exp"])), abs(float(b["W_exp"]))) / math.sqrt(3)


def _estimate(
    value: float, a: Sequence[tuple[Row, float]], b: Sequence[tuple[Row, float]], same: bool, more: Sequence[float] = ()
) -> Estimate:
    """A value that depends on W of conditions with given derivatives. Lines in J (scatter, noise) belong to a condition
    alone; all others are one error of a session's instruments, of both sessions where they are the same."""
    shared: dict[tuple[str, str], float] = defaultdict(float)
    nu: dict[tuple[str, str], float] = {}
    parts = [(part, math.inf) for part in more]
    for name, weights in (("A", a), ("B", b)):
        for row, weight in weights:
            for line in row["uncertainty"]:
                part = weight * line["c"] * line["u"]
                dof = math.inf if line["nu"] is None else line["nu"]
                if line["unit"] == "J":
                    parts.append((part, dof))
                else:
                    key = ("" if same else name, line["source"])
                    shared[key] += part
                    nu[key] = dof
    return combine(value, [*parts, *((part, nu[key]) for key, part in shared.items())])


def _overall(pairs: Sequence[tuple[Row, Row]], same: bool) -> dict[str, Any] | None:
    """Sum of W_B over sum of W_A, less 1; None without a pair."""
    total = math.fsum(a["W_exp"] for a, _ in pairs)
    if not pairs or not total > 0:
        return None
    ratio = math.fsum(b["W_exp"] for _, b in pairs) / total
    levels = [_level_part(a, b) / total for a, b in pairs]
    found = _estimate(
        ratio - 1, [(a, -ratio / total) for a, _ in pairs], [(b, 1 / total) for _, b in pairs], same, levels
    )
    nu = None if math.isinf(found.nu) else found.nu
    return {"relative": found.value, "U": found.U, "k": found.k, "nu": nu, "n": len(pairs)}


def kendall(x: Sequence[float], y: Sequence[float]) -> float | None:
    """Kendall's tau-b (Biometrika 33, 239 (1945)); None where one of both does not vary."""
    signs = [(_sign(x[i] - x[j]), _sign(y[i] - y[j])) for i, j in combinations(range(len(x)), 2)]
    ups, downs = sum(s * s for s, _ in signs), sum(t * t for _, t in signs)
    return sum(s * t for s, t in signs) / math.sqrt(ups * downs) if ups and downs else None


def _sign(value: float) -> int:
    return (value > 0) - (value < 0)


def _ranks(pairs: Sequence[tuple[Row, Row]]) -> dict[str, Any]:
    """Tau over the pairs with its 95 % interval (Fieller, Hartley and Pearson, Biometrika 44, 470 (1957): tanh of
    atanh(tau) ± 1.96 sqrt(0.437/(n - 4)), from 10 pairs on), and the orders that both sessions decide differently."""
    tau = kendall([a["W_exp"] for a, _ in pairs], [b["W_exp"] for _, b in pairs])
    n, interval = len(pairs), None
    if tau is not None and n >= 10:
        z, half = math.atanh(max(-1 + 1e-12, min(tau, 1 - 1e-12))), 1.96 * math.sqrt(0.437 / (n - 4))
        interval = [math.tanh(z - half), math.tanh(z + half)]
    opposite, decided = 0, []
    for (a, b), (c, d) in combinations(pairs, 2):
        in_a, in_b = _order(a, c), _order(b, d)
        if (a["W_exp"] - c["W_exp"]) * (b["W_exp"] - d["W_exp"]) < 0:
            opposite += 1
            if in_a * in_b < 0:
                decided.append(f"{a['id']} and {c['id']}")
    return {"n": n, "tau": tau, "interval": interval, "orders": n * (n - 1) // 2, "opposite": opposite,
            "decided_opposite": decided}  # fmt: skip


def _order(one: Row, other: Row) -> int:
    """Which of two conditions of a session has the larger W: 1, -1, or 0 where their U does not tell."""
    found = _estimate(one["W_exp"] - other["W_exp"], [(one, 1.0), (other, -1.0)], (), True)
    return _sign(found.value) if abs(found.value) > found.U else 0
