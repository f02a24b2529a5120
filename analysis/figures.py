"""Figures of a report, as SVG text: equal reports give equal bytes."""

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Plot", "energy_figure", "offset_figure", "plots", "svg"]

Row = dict[str, Any]

BLUE, ORANGE, GREY = "#0072b2", "#d55e00", "#8a8a8a"
# Okabe and Ito's palette, safe for the colour-blind
SERIES = (BLUE, "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#000000", "#d55e00", "#999933")
MARKERS = "osD^vPX*"
MOST_PANELS = 12
WIDTH = 7.2  # inches

AXES: dict[str, tuple[str, float]] = {
    "fill": ("fill, %", 100.0),
    "density": ("grain density, g/cm³", 1e-3),
    "diameter": ("grain diameter, mm", 1e3),
    "frequency": ("frequency, Hz", 1.0),
    "acceleration_set": ("acceleration, m/s²", 1.0),
}
MOST_LABELS = 12  # of a legend: more would leave no room for the panels
NEAR = 20.0  # per cent: linear below, logarithmic above
STYLE: Any = {  # names of matplotlib's settings, which its stubs list one by one
    "svg.fonttype": "none", "font.family": "sans-serif", "font.size": 9.0, "axes.titlesize": 9.0,
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "axes.axisbelow": True,
    "grid.color": "#e4e4e4", "grid.linewidth": 0.6, "legend.frameon": False, "lines.linewidth": 1.4,
    "path.simplify": False,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Plot:
    """A figure ready for a page. name: of its file; alt: what it shows, in words; svg: the drawing."""

    name: str
    title: str
    alt: str
    svg: str


def plots(report: Row) -> tuple[Plot, ...]:
    """The figures that a report has the numbers for."""
    found = []
    if report["conditions"]:
        label = AXES[swept(report["conditions"])][0].split(",")[0]
        alt = (
            f"Dissipated energy per cycle against {label}: measured means with 95 % uncertainty bars, "
            "the predicted energy as a line, the detection limit in grey. The numbers are in the table of conditions."
        )
        found.append(Plot("energy", "Energy per cycle", alt, svg(energy_figure(report), "energy")))
    if any(row["offset"] is not None for row in report["conditions"]):
        alt = (
            "Offset of the measured from the predicted energy, in per cent with 95 % uncertainty bars, against the "
            "predicted energy on a logarithmic axis. The numbers are in the table of conditions."
        )
        found.append(Plot("offset", "Offset", alt, svg(offset_figure(report), "offset")))
    return tuple(found)


def svg(figure: "Figure", salt: str) -> str:
    """The figure as SVG text, without date; `salt` makes its ids differ from those of other figures on a page."""
    import matplotlib

    text = io.StringIO()
    with matplotlib.rc_context({**STYLE, "svg.hashsalt": f"rig-{salt}"}):
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    return text.getvalue()


def swept(rows: Sequence[Row]) -> str:
    """The quantity that the conditions vary: fill, density, diameter or frequency, else the acceleration."""
    known = (name for name in AXES if all(row[name] is not None for row in rows))
    varied = (name for name in known if len({row[name] for row in rows}) > 1)
    return next(varied, "acceleration_set")


def energy_figure(report: Row) -> "Figure":
    """W_exp with U and W_T against the swept quantity, a panel per acceleration."""
    import matplotlib
    from matplotlib.figure import Figure

    rows: list[Row] = report["conditions"]
    x = swept(rows)
    levels = sorted({row["acceleration_set"] for row in rows}) if x != "acceleration_set" else [None]
    levels = levels[:MOST_PANELS]
    across = 1 if len(levels) == 1 else 2
    down = -(-len(levels) // across)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 0.5 + (3.4 if down == 1 else 2.5 * down)))
        panels = figure.subplots(down, across, squeeze=False).ravel()
        series = _series(rows, x)
        for axes, level in zip(panels, levels, strict=False):
            shown = [row for row in rows if level in (None, row["acceleration_set"])]
            _energy_panel(axes, shown, x, series)
            axes.set_title("" if level is None else f"{level:g} m/s²", loc="left", fontweight="bold")
        for axes in panels[len(levels) :]:
            axes.set_axis_off()
        for axes in panels[max(0, len(levels) - across) : len(levels)]:
            axes.set_xlabel(AXES[x][0])
        for axes in panels[::across]:
            axes.set_ylabel("energy, mJ per cycle")
        handles, labels = (found[:MOST_LABELS] for found in panels[0].get_legend_handles_labels())
        columns = 3 if len(labels) <= 3 else 2
        lines = -(-len(labels) // columns)
        _margins(figure, top=0.35 + 0.2 * lines)
        figure.legend(handles, labels, loc="upper right", ncols=columns)
    return figure


def offset_figure(report: Row) -> "Figure":
    """W_exp / W_T - 1 with U against W_T."""
    import matplotlib
    from matplotlib.figure import Figure

    rows = [row for row in report["conditions"] if row["offset"] is not None]
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 3.0))
        axes = figure.subplots()
        _margins(figure, top=0.1)
        axes.set_xscale("log")
        axes.set_yscale(
            "symlog", linthresh=NEAR
        )  # a detectable offset of a few microjoules can be thousands of per cent
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter("{x:g}")
        axes.axhline(0, color="black", linewidth=0.8)
        ratio, U = report["agreement"]["ratio"], report["agreement"]["U_ratio"]
        if ratio is not None:  # before the points: a single one leaves a logarithmic axis without a width
            axes.axhline(100 * (ratio - 1), color=ORANGE, label="energy-weighted, with U (95 %)")
            axes.axhspan(100 * (ratio - 1 - U), 100 * (ratio - 1 + U), color=ORANGE, alpha=0.18, linewidth=0)
        axes.errorbar(
            [1e3 * row["W_T"] for row in rows],
            [100 * row["offset"] for row in rows],
            [100 * row["U_offset"] for row in rows],
            fmt="o", color=BLUE, markersize=4, elinewidth=1, capsize=2, label="W_exp / W_T - 1, with U (95 %)",
        )  # fmt: skip
        known = [1e3 * row["W_T"] for row in rows]
        if len(set(known)) == 1:  # rounding may leave a logarithmic axis with a single point no width at all
            axes.set_xlim(known[0] / 2, known[0] * 2)
        axes.set_xlabel("predicted energy W_T, mJ per cycle")
        axes.set_ylabel("offset, %")
        axes.legend(loc="best")
    return figure


def _margins(figure: "Figure", top: float) -> None:
    """Margins in inches, set by hand: matplotlib's own layout engine draws everything twice."""
    width, height = figure.get_size_inches()
    figure.subplots_adjust(
        left=0.75 / width, right=1 - 0.08 / width, bottom=0.5 / height, top=1 - top / height, hspace=0.24, wspace=0.24
    )


def _energy_panel(axes: "Axes", rows: Sequence[Row], x: str, series: dict[str, Callable[[Row], bool]]) -> None:
    scale = AXES[x][1]
    for number, (label, belongs) in enumerate(series.items()):
        mine = sorted((row for row in rows if belongs(row)), key=lambda row: float(row[x]))
        if not mine:
            continue
        colour, marker = SERIES[number % len(SERIES)], MARKERS[number % len(MARKERS)]
        line = ORANGE if len(series) == 1 else colour
        at = [scale * row[x] for row in mine]
        told = [row for row in mine if row["W_T"] is not None]
        if told:
            W_T, U_T = [1e3 * row["W_T"] for row in told], [1e3 * row["U_W_T"] for row in told]
            where = [scale * row[x] for row in told]
            axes.plot(where, W_T, color=line, label=f"W_T predicted{label}")
            low, high = ([w + s * u for w, u in zip(W_T, U_T, strict=True)] for s in (-1, 1))
            axes.fill_between(where, low, high, color=line, alpha=0.18, linewidth=0)
        axes.errorbar(
            at, [1e3 * row["W_exp"] for row in mine], [1e3 * row["U_W_exp"] for row in mine], fmt=marker, color=colour,
            markersize=4, elinewidth=1, capsize=2, label=f"W_exp measured, U (95 %){label}",
        )  # fmt: skip
        if len(series) == 1:
            limit = [1e3 * row["W_detect"] for row in mine]
            axes.fill_between(at, 0, limit, color=GREY, alpha=0.35, linewidth=0, label="below detection")


def _series(rows: Sequence[Row], x: str) -> dict[str, Callable[[Row], bool]]:
    """Conditions that differ in more than the axis and the panel, by the label that tells them apart."""
    kept = ("bed", "material", "diameter", "fill", "frequency", "drive")
    names = [name for name in kept if name != x and len({row[name] for row in rows}) > 1]
    if x == "density":
        names = [name for name in names if name != "material"]
    keys = dict.fromkeys(tuple(row[name] for name in names) for row in rows)

    def belongs(key: tuple[Any, ...]) -> Callable[[Row], bool]:
        return lambda row: tuple(row[name] for name in names) == key

    return {
        "".join(f", {_word(name, value)}" for name, value in zip(names, key, strict=True)): belongs(key) for key in keys
    }


def _word(name: str, value: Any) -> str:
    if value is None:
        return f"{name} not known"
    shown = {"diameter": ("mm", 1e3), "fill": ("%", 100.0), "frequency": ("Hz", 1.0)}
    return f"{value * shown[name][1]:g} {shown[name][0]}" if name in shown else str(value)
