"""Work-precision, model variants and scaling as figures; equal rows give equal bytes."""

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from analysis.report.figures.axes import SERIES
from analysis.report.figures.matplotlib_style import STYLE, svg
from daq.whole_files import write_whole
from rig.benchmarks.results.tables import SHORT, own_rows, succeeded

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Row = dict[str, Any]

MARKS = {
    "event-driven (ours)": "*",
    "RK4, events located": "o",
    "semi-implicit Euler": "s",
    "Moreau time stepping": "D",
    "solve_ivp RK45": "^",
    "solve_ivp DOP853": "v",
    "solve_ivp Radau": "P",
    "solve_ivp LSODA": "X",
}
LEAST_ERROR = 1e-16
DOTS_PER_INCH = 120


class Drawn(NamedTuple):
    """A figure: `name` of its files; `alt` describes it in words."""

    name: str
    alt: str


PRECISION = Drawn(
    "precision",
    "Work-precision diagrams, one panel per slider or single mass: microseconds per cycle against the relative error of the "
    "energy per cycle, both logarithmic. The event-driven method is a single point at round-off in the lower left; RK4 "
    "falls with order four, the first-order methods fall slowly, solve_ivp lies thousands of times higher. The numbers "
    "are in the tables.",
)
LADDER = Drawn(
    "ladder",
    "Model ladder: milliseconds per condition against the error of the energy against many rows per layer, both "
    "logarithmic, a colour per model and a point per level. The numbers are in the table.",
)
SCALING = Drawn(
    "scaling",
    "Time against size, both logarithmic, one panel for each axis of the table, with the fitted exponent in the title. "
    "The numbers are in the tables.",
)


def drawn(rows: Sequence[Row]) -> list[Drawn]:
    """Return the figures for which the rows have numbers."""
    kinds = {row["kind"] for row in rows}
    needs = ((PRECISION, "precision"), (LADDER, "layers"), (SCALING, "exponent"))
    return [figure for figure, kind in needs if kind in kinds]


def write_figures(rows: Sequence[Row], folder: Path) -> list[Path]:
    """Write every figure as NAME.svg and NAME.png; return the paths. Raises OSError."""
    import matplotlib

    folder.mkdir(parents=True, exist_ok=True)
    draw = {PRECISION: precision_figure, LADDER: ladder_figure, SCALING: scaling_figure}
    written = []
    for which in drawn(rows):
        figure = draw[which](rows)
        text, data = svg(figure, which.name), io.BytesIO()
        with matplotlib.rc_context(STYLE):
            figure.savefig(data, format="png", dpi=DOTS_PER_INCH, metadata={"Software": None})
        written += [folder / f"{which.name}.svg", folder / f"{which.name}.png"]
        write_whole(written[-2], text)
        write_whole(written[-1], data.getvalue())
    return written


def precision_figure(rows: Sequence[Row]) -> "Figure":
    """Draw one panel per problem, one curve per method."""
    precise = succeeded(rows)
    problems = list(dict.fromkeys(row["problem"] for row in precise))
    figure, panels = _panels(len(problems), "error of W", "µs per cycle")
    for axes, problem in zip(panels, problems, strict=True):
        for colour, (method, mark) in zip(SERIES, MARKS.items(), strict=True):
            own = own_rows(precise, problem, method)
            x = [max(row["error"], LEAST_ERROR) for row in own]
            y = [row["us_per_cycle"]["median"] for row in own]
            large = 11.0 if mark == "*" else 3.5
            axes.plot(
                x,
                y,
                color=colour,
                marker=mark,
                markersize=large,
                linewidth=0.9,
                label=SHORT[method],
            )
        axes.set_title(problem, loc="left")
        axes.set_xlim(1.0, 0.3 * LEAST_ERROR)
    _legend(figure, panels[0])
    return figure


def ladder_figure(rows: Sequence[Row]) -> "Figure":
    """Draw time against model error, one colour per model."""
    own = [row for row in rows if row["kind"] == "layers"]
    figure, (axes,) = _panels(1, "error of W against many rows", "ms per condition")
    for number, method in enumerate(dict.fromkeys(row["method"] for row in own)):
        points = [row for row in own if row["method"] == method]
        axes.plot(
            [max(abs(row["model_error"]), 1e-6) for row in points],
            [row["ms"]["median"] for row in points],
            color=SERIES[number % len(SERIES)],
            marker="osD^vPX*"[number % 8],
            linestyle="none",
            label=method,
        )
    axes.invert_xaxis()
    axes.legend(loc="best", fontsize=7.0)
    return figure


def scaling_figure(rows: Sequence[Row]) -> "Figure":
    """Draw one panel per axis."""
    fits = [row for row in rows if row["kind"] == "exponent"]
    figure, panels = _panels(len(fits), "size", "ms")
    for axes, fit in zip(panels, fits, strict=True):
        own = [row for row in rows if (row["kind"], row.get("axis")) == ("scaling", fit["axis"])]
        x, y = [row["size"] for row in own], [row["ms"]["median"] for row in own]
        axes.plot(x, y, color=SERIES[0], marker="o", linestyle="none")
        middle_x, middle_y = (x[0] * x[-1]) ** 0.5, (y[0] * y[-1]) ** 0.5
        axes.plot(
            x, [middle_y * (value / middle_x) ** fit["exponent"] for value in x], color=SERIES[-2]
        )
        axes.set_title(f"{fit['axis']}: exponent {fit['exponent']:.2f}", loc="left")
    return figure


def _panels(count: int, x: str, y: str) -> "tuple[Figure, list[Axes]]":
    import matplotlib
    from matplotlib.figure import Figure

    columns = min(count, 3)
    lines = -(-count // columns)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(3.0 * columns + 0.6, 2.6 * lines + 0.5), layout="constrained")
        grid = figure.subplots(lines, columns, squeeze=False)
        panels = []
        for number, axes in enumerate(grid.ravel()):
            if number >= count:
                axes.set_axis_off()
                continue
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.set_xlabel(x)
            axes.set_ylabel(y)
            panels.append(axes)
    return figure, panels


def _legend(figure: "Figure", axes: "Axes") -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
