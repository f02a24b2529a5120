"""Figures of the energy per cycle against the quantities that were varied."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from analysis.report.figures.axes import (
    BLUE,
    GREY,
    MARKERS,
    ORANGE,
    SERIES,
    Panel,
    Scale,
    legend,
    linear,
    logarithmic,
)
from analysis.report.figures.drawing import Drawing, Plot, thinned
from analysis.results.condition_row import ConditionRow
from analysis.results.report import Report
from analysis.text import counted

__all__ = ["AXES", "energy_plots", "swept"]

AXES: dict[str, tuple[str, float]] = {
    "fill": ("fill, %", 100.0),
    "density": ("grain density, g/cm³", 1e-3),
    "diameter": ("grain diameter, mm", 1e3),
    "frequency": ("frequency, Hz", 1.0),
    "acceleration_set": ("acceleration, m/s²", 1.0),
}
UNITS = {"diameter": ("mm", 1e3), "fill": ("%", 100.0), "frequency": ("Hz", 1.0), "acceleration_set": ("m/s²", 1.0),
         "density": ("g/cm³", 1e-3)}  # fmt: skip
MOST_PANELS = 12
MOST_CONDITIONS = 100  # in a panel
SAME = 2e-3  # relative difference of settings that count as equal
MOST_SERIES = len(SERIES)
MARKS = [
    ("o", BLUE, "W_exp measured, with U (95 %)"),
    ("run", BLUE, "single runs"),
    ("line", ORANGE, "W_T predicted"),
    ("band", ORANGE, "its U (95 %)"),
    ("band", GREY, "below W_detect: may be a phase error"),
]


def energy_plots(report: Report) -> tuple[Plot, ...]:
    """Return the figures of W against the quantities that the conditions vary.

    W against a for each fill, size, density or frequency, on linear and logarithmic axes; W against
    the other varied quantity.
    """
    rows = _snapped(report.conditions)
    if not rows:
        return ()
    if len(rows) == 1:
        return (_single(rows[0]),)
    found = []
    if len({row.acceleration_set for row in rows}) > 1:
        found += [_against_acceleration(rows, False), _against_acceleration(rows, True)]
    if swept(rows) != "acceleration_set":
        found.append(_against(rows, swept(rows)))
    elif not found:
        found.append(_beds(rows))
    return tuple(found)


def _snapped(rows: Sequence[ConditionRow]) -> list[ConditionRow]:
    """Return the conditions with settings that agree within SAME made equal.

    A frequency or level that was estimated from a record is never twice the same.
    """
    changed: list[dict[str, float]] = [{} for _ in rows]
    for name in AXES:
        known = [
            (value, place)
            for place, value in enumerate(getattr(row, name) for row in rows)
            if value is not None
        ]
        last: float | None = None
        for value, place in sorted(known):
            if last is not None and value <= last * (1 + SAME) and value != last:
                changed[place][name] = last
            else:
                last = value
    return [replace(row, **new) if new else row for row, new in zip(rows, changed, strict=True)]  # type: ignore[arg-type]


def swept(rows: Sequence[ConditionRow]) -> str:
    """Return the quantity that the conditions vary: fill, density, diameter or frequency, otherwise
    the acceleration.
    """
    known = (name for name in AXES if all(getattr(row, name) is not None for row in rows))
    varied = (name for name in known if len({getattr(row, name) for row in rows}) > 1)
    return next(varied, "acceleration_set")


def series(rows: Sequence[ConditionRow], x: str) -> dict[str, list[ConditionRow]]:
    """Return the conditions grouped by their settings other than x, by the label of the group, each
    in the order of x.
    """
    kept = (
        "bed",
        "material",
        "density",
        "diameter",
        "fill",
        "frequency",
        "drive",
        "acceleration_set",
    )
    names = [name for name in kept if name != x and len({getattr(row, name) for row in rows}) > 1]
    if "density" in (x, *names) and "material" in names:
        names.remove("material")
    found: dict[str, list[ConditionRow]] = {}
    for row in rows:
        also = row.varied.items()
        words = [
            *(word(name, getattr(row, name)) for name in names),
            *(f"{name} {text}" for name, text in also),
        ]
        found.setdefault(", ".join(words), []).append(row)
    return {
        label: sorted(mine, key=lambda row: float(getattr(row, x))) for label, mine in found.items()
    }


def word(name: str, value: str | float | None) -> str:
    """Return a setting in words."""
    if value is None:
        return f"{name} not known"
    if name not in UNITS or isinstance(value, str):
        return str(value)
    unit, scale = UNITS[name]
    return f"{value * scale:.4g} {unit}"


def _against_acceleration(rows: Sequence[ConditionRow], log: bool) -> Plot:
    """Return W against a, with one panel for each of the lines in the paper's Figs. 11 to 13."""
    groups = series(rows, "acceleration_set")
    shown = list(groups.items())[:MOST_PANELS]
    panels = [
        legend(MARKS),
        *(_panel(mine, "acceleration_set", label, log) for label, mine in shown),
    ]
    what = "logarithmic axes" if log else "linear axes"
    alt = (
        f"Energy per cycle against acceleration, {counted(len(shown), 'panel')}, {what}: measured means with 95 % "
        "uncertainty bars and single runs, W_T as a line with its band, W_detect in grey."
        + _rest(len(groups) - len(shown))
    )
    title = "Energy against acceleration" + (" on logarithmic axes" if log else "")
    return Plot("energy_log" if log else "energy", title, alt, tuple(panels))


def _rest(count: int) -> str:
    """Return where to find the groups that are not drawn."""
    more = f" {counted(count, 'more group')}: in the table only." if count > 0 else ""
    return f"{more} The numbers are in the table of conditions."


def _against(rows: Sequence[ConditionRow], x: str) -> Plot:
    """Return W against x with a panel for each acceleration, in which the largest W is easy to see."""
    label = AXES[x][0]
    levels = sorted({row.acceleration_set for row in rows if row.acceleration_set is not None})
    shown = levels[:MOST_PANELS]
    panels = [legend(MARKS)]
    for level in shown:
        mine = [row for row in rows if row.acceleration_set == level]
        groups = series(mine, x)
        if len(groups) == 1:
            panels.append(
                _panel(next(iter(groups.values())), x, word("acceleration_set", level), False)
            )
        else:
            panels += [
                _panel(group, x, f"{word('acceleration_set', level)}, {name}", False)
                for name, group in groups.items()
            ]
    panels = panels[: MOST_PANELS + 1]
    alt = (
        f"Energy per cycle against {label.split(',')[0]}, a panel for each acceleration: measured means with 95 % "
        "uncertainty bars and single runs, W_T as a line with its band, W_detect in grey."
        + _rest(len(levels) - len(shown))
    )
    return Plot(f"energy_{x}", f"Energy against {label.split(',')[0]}", alt, tuple(panels))


def _panel(rows: Sequence[ConditionRow], x: str, title: str, log: bool) -> Drawing:
    """Return one panel of W against x."""
    name, scale = AXES[x]
    if len(rows) > MOST_CONDITIONS:
        shown = thinned(rows, MOST_CONDITIONS)
        title, rows = f"{title}, {len(shown)} of {len(rows)} shown".lstrip(", "), shown
    at = [scale * getattr(row, x) for row in rows]
    predicted = [
        (scale * getattr(row, x), 1e3 * row.W_T, 1e3 * (row.U_W_T or 0.0))
        for row in rows
        if row.W_T is not None
    ]
    runs = [
        (place, 1e3 * run.W_exp) for place, row in zip(at, rows, strict=True) for run in row.runs
    ]
    heights = [
        *(1e3 * (row.W_exp + sign * row.U_W_exp) for row in rows for sign in (-1, 1)),
        *(
            1e3 * (row.W_T + sign * (row.U_W_T or 0.0))
            for row in rows
            if row.W_T is not None
            for sign in (-1, 1)
        ),
        *(W for _, W in runs),
    ]
    axes: Callable[..., Scale] = logarithmic if log else linear
    if log:
        # The axis ends at the detection limit: nothing far below it is significant.
        floor = min((1e3 * max(row.detected, 1e-9) for row in rows), default=1e-6)
        heights = [max(height, floor / 3) for height in heights]
    panel = Panel(
        axes(at),
        axes(heights) if log else linear(heights, zero=True),
        name,
        "W, mJ per cycle",
        title,
    )
    if len(at) == 1:
        panel.x = linear((at[0],))
    panel.band(at, [panel.y.low] * len(at), [1e3 * row.detected for row in rows], GREY, 0.35)
    if predicted:
        where, W_T, U = (list(column) for column in zip(*predicted, strict=True))
        panel.band(where, [w - u for w, u in zip(W_T, U, strict=True)], [w + u for w, u in zip(W_T, U, strict=True)],
                   ORANGE, 0.25)  # fmt: skip
        panel.line(where, W_T, ORANGE)
    panel.dots([place for place, _ in runs], [W for _, W in runs], BLUE)
    panel.bars(at, [1e3 * row.W_exp for row in rows], [1e3 * row.U_W_exp for row in rows], BLUE)
    return panel.drawing()


def _single(row: ConditionRow) -> Plot:
    """Return the runs of a single condition, their mean with U, and the prediction, side by side."""
    runs = [1e3 * run.W_exp for run in row.runs]
    values = [*runs, *(1e3 * (row.W_exp + sign * row.U_W_exp) for sign in (-1, 1))]
    names, W_T, U_W_T = ["runs", "W_exp"], row.W_T, row.U_W_T or 0.0
    if W_T is not None:
        values += [1e3 * (W_T + sign * U_W_T) for sign in (-1, 1)]
        names.append("W_T")
    panel = Panel(
        linear((-0.5, len(names) - 0.5)), linear(values), "", "W, mJ per cycle", row.id, names=names
    )
    panel.spread(panel.y.low, 1e3 * row.detected, GREY, 0.35)
    count = max(len(runs) - 1, 1)
    panel.dots([0.5 * (number / count - 0.5) for number in range(len(runs))], runs, BLUE, radius=3)
    panel.bars([1], [1e3 * row.W_exp], [1e3 * row.U_W_exp], BLUE)
    if W_T is not None:
        panel.bars([2], [1e3 * W_T], [1e3 * U_W_T], ORANGE, "D")
    alt = (
        f"Energy per cycle of the only condition, {row.id}: {counted(len(runs), 'single run')}, the mean with its "
        "95 % uncertainty, and the predicted energy with its own. The numbers are in the table of conditions."
    )
    return Plot("energy", "Energy per cycle", alt, (panel.drawing(),), across=1)


def _beds(rows: Sequence[ConditionRow]) -> Plot:
    """Return conditions that differ in no quantity with an axis, side by side."""
    shown = rows[:MOST_PANELS]
    values = [1e3 * (row.W_exp + sign * row.U_W_exp) for row in shown for sign in (-1, 1)]
    values += [1e3 * row.W_T for row in shown if row.W_T is not None]
    varied = {tuple(row.varied) for row in shown}
    only = "condition"
    if len(varied) == 1 and len(paths := next(iter(varied))) == 1:
        (only,) = paths
    names = [row.varied.get(only, row.id) for row in shown]
    panel = Panel(
        linear((-0.5, len(shown) - 0.5)),
        linear(values, zero=True),
        only,
        "W, mJ per cycle",
        names=names,
    )
    for place, row in enumerate(shown):
        panel.dots([place] * len(row.runs), [1e3 * run.W_exp for run in row.runs], BLUE)
        panel.bars([place], [1e3 * row.W_exp], [1e3 * row.U_W_exp], BLUE, MARKERS[0])
        if row.W_T is not None:
            panel.bars(
                [place + 0.25], [1e3 * row.W_T], [1e3 * (row.U_W_T or 0.0)], ORANGE, MARKERS[2]
            )
    alt = (
        "Energy per cycle of each condition: single runs, means with 95 % uncertainty bars, and the predicted energy "
        "beside them." + _rest(len(rows) - len(shown))
    )
    words = [
        ("o", BLUE, "W_exp measured, with U (95 %)"),
        ("run", BLUE, "single runs"),
        ("D", ORANGE, "W_T predicted"),
    ]
    return Plot("energy", "Energy per cycle", alt, (legend(words), panel.drawing()), across=1)
