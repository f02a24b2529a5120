"""Files of a parametric study: a figure (SVG, PNG) and a CSV for each panel, and a CSV of the
paper's statements.

A study is a plain dict as `rig.theory.paper.studies` returns it; equal studies give equal bytes.
"""

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from analysis.report.figures.axes import MARKERS, ORANGE, SERIES
from analysis.report.figures.matplotlib_style import STYLE, svg
from daq.whole_files import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["panel_csv", "panel_figure", "rows_csv", "write_study"]

Panel = dict[str, Any]

SIZE = (7.2, 4.2)  # inches
MARKED = 25  # largest number of markers on a curve
DOTS_PER_INCH = 150
COLUMNS = (
    "equation",
    "subject",
    "printed",
    "corrected",
    "printed_value",
    "corrected_value",
    "unit",
    "holds",
    "note",
)


def write_study(study: dict[str, Any], out_dir: Path) -> tuple[Path, ...]:
    """Write all files of a study to a folder, which is made where missing; return the paths in
    order. OSError.
    """
    out_dir.mkdir(parents=True, exist_ok=True)
    written = [_write(out_dir / f"{study['study']}.csv", rows_csv(study["rows"]).encode())]
    for panel in study["panels"]:
        figure = panel_figure(panel)
        name = panel["name"]
        written += [
            _write(out_dir / f"{name}.csv", panel_csv(panel).encode()),
            _write(out_dir / f"{name}.svg", svg(figure, name).encode()),
            _write(out_dir / f"{name}.png", _png(figure)),
        ]
    return tuple(written)


def rows_csv(rows: Iterable[dict[str, Any]]) -> str:
    """Return statements of the paper, a line each: as printed, corrected, a number of each, yes or
    no.
    """
    cells = []
    for row in rows:
        shown = {**row, "holds": "yes" if row["holds"] else "no"}
        cells.append([_cell(shown[name]) for name in COLUMNS])
    return _csv(COLUMNS, cells)


def panel_csv(panel: Panel) -> str:
    """Return a column for x and one for each curve; SI units in the header."""
    x, y = panel["x"], panel["y"]
    head = [
        _axis(x),
        *(f"{_axis(y)}; {panel['legend']} {curve['label']}" for curve in panel["curves"]),
    ]
    columns = [x["values"], *(curve["values"] for curve in panel["curves"])]
    return _csv(head, ([_cell(value) for value in line] for line in zip(*columns, strict=True)))


def panel_figure(panel: Panel) -> "Figure":
    """Return the curves of a panel; values that the paper quotes are marked, filled where they
    hold, crossed where they do not.
    """
    import matplotlib
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    x, y = panel["x"], panel["y"]
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=SIZE)
        axes = figure.subplots()
        figure.subplots_adjust(left=0.11, right=0.98, bottom=0.13, top=0.9)
        for number, curve in enumerate(panel["curves"]):
            points = len(x["values"])
            axes.plot(
                x["values"],
                curve["values"],
                color=SERIES[number % len(SERIES)],
                marker=MARKERS[number % len(MARKERS)],
                markersize=3.5,
                markevery=max(1, points // MARKED),
                label=f"{panel['legend']} {curve['label']}",
            )
        for mark in panel["marks"]:
            verdict = "holds" if mark["holds"] else "does not hold"
            axes.plot(
                [mark["x"]],
                [mark["y"]],
                color=ORANGE,
                linestyle="none",
                marker="o" if mark["holds"] else "X",
                markersize=9,
                markeredgecolor="black",
                zorder=5,
                label=f"{mark['label']}: {verdict}",
            )
        axes.set_title(f"{panel['title']} ({panel['paper']})", loc="left", fontweight="bold")
        axes.set_xlabel(_axis(x))
        axes.set_ylabel(_axis(y))
        axes.set_ylim(bottom=0.0)
        if all(float(value).is_integer() for value in x["values"]):
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.legend(loc="best", frameon=True, framealpha=0.9, edgecolor="none")
    return figure


def _axis(quantity: dict[str, Any]) -> str:
    return (
        f"{quantity['label']}, {quantity['unit']}" if quantity["unit"] else str(quantity["label"])
    )


def _cell(value: Any) -> str:
    if value is None:
        return ""
    return repr(value) if isinstance(value, float) else str(value)


def _csv(head: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(head)
    table.writerows(lines)
    return text.getvalue()


def _png(figure: "Figure") -> bytes:
    import matplotlib

    data = io.BytesIO()
    with matplotlib.rc_context(STYLE):
        figure.savefig(data, format="png", dpi=DOTS_PER_INCH, metadata={"Software": None})
    return data.getvalue()


def _write(path: Path, data: bytes) -> Path:
    write_whole(path, data)
    return path
