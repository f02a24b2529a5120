"""The uses of matplotlib: the style of the study figures, and drawings as PNG."""

import io
from typing import TYPE_CHECKING, Any

from analysis.report.figures.axes import MARKERS, ORANGE, SERIES
from analysis.report.figures.drawing import Area, Drawing, Mark, PlottedLine, Word, outline
from daq.strange_text import visible

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["MARKERS", "ORANGE", "SERIES", "STYLE", "png", "svg"]

STYLE: Any = {  # Any: matplotlib's stubs list the names of settings one by one
    "svg.fonttype": "none", "font.family": "sans-serif", "font.size": 9.0, "axes.titlesize": 9.0,
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "axes.axisbelow": True,
    "grid.color": "#e4e4e4", "grid.linewidth": 0.6, "legend.frameon": False, "lines.linewidth": 1.4,
    "path.simplify": False,
}  # fmt: skip
PIXELS = 96.0  # of a drawing per inch
FINER = 2  # pixels of the file per pixel of the drawing
WORDS: Any = {"start": "left", "middle": "center", "end": "right"}


def svg(figure: "Figure", salt: str) -> str:
    """Return the figure as SVG text, without date; `salt` makes its ids differ from those of other
    figures on a page.
    """
    import matplotlib

    text = io.StringIO()
    with matplotlib.rc_context({**STYLE, "svg.hashsalt": f"rig-{salt}"}):
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    return text.getvalue()


def png(drawing: Drawing) -> bytes:
    """Return a drawing as PNG on white, two pixels for each of its own."""
    import matplotlib
    from matplotlib.figure import Figure

    data = io.BytesIO()
    with matplotlib.rc_context({**STYLE, "path.sketch": None}):
        figure = Figure(figsize=(drawing.width / PIXELS, drawing.height / PIXELS))
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set(xlim=(0.0, drawing.width), ylim=(drawing.height, 0.0))
        axes.set_axis_off()
        for order, mark in enumerate(drawing.marks):
            axes.add_artist(_artist(mark, order))
        figure.savefig(data, format="png", dpi=FINER * PIXELS, metadata={"Software": None})
    return data.getvalue()


def _artist(mark: Mark, order: int) -> Any:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Circle, Polygon
    from matplotlib.text import Text

    point = 72.0 / PIXELS
    if isinstance(mark, PlottedLine):
        x, y = zip(*mark.points, strict=True)
        style: Any = (0, tuple(float(n) for n in mark.dash.split())) if mark.dash else "-"
        return Line2D(
            x, y, color=mark.colour, linewidth=mark.width * point, linestyle=style, zorder=order
        )
    if isinstance(mark, Area):
        return Polygon(
            list(mark.points), color=mark.colour, alpha=mark.opacity, linewidth=0, zorder=order
        )
    if isinstance(mark, Word):
        return Text(
            *mark.at, visible(mark.text), parse_math=False, color=mark.colour,
            fontsize=mark.size * point, rotation=90 if mark.upright else 0,
            fontweight="bold" if mark.bold else "normal", horizontalalignment=WORDS[mark.anchor],
            verticalalignment="baseline", rotation_mode="anchor", zorder=order,
        )  # fmt: skip
    paint: Any = {
        "facecolor": "white" if mark.hollow else mark.colour,
        "edgecolor": mark.colour,
        "linewidth": point,
    }
    if mark.shape == "o":
        return Circle(mark.at, mark.radius, zorder=order, **paint)
    return Polygon(list(outline(mark)), zorder=order, **paint)
