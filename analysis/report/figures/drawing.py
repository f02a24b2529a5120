"""Drawings of lines, areas, dots and words, and their SVG; no library is loaded.

Equal drawings give equal bytes. Lengths are pixels, y points down. A drawing is small enough to fit
a phone; several make a figure.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from analysis.text import escape

__all__ = [
    "MOST_POINTS",
    "Area",
    "Dot",
    "Drawing",
    "Mark",
    "Plot",
    "PlottedLine",
    "Word",
    "arranged",
    "outline",
    "svg_text",
    "thinned",
    "thinned_words",
]

Points = Sequence[tuple[float, float]]
FONT = "system-ui, sans-serif"
GAP = 12.0  # between the drawings of a figure
MOST_POINTS = 500
"""Largest number of dots or bars in a panel: more cover each other, and make a page slow."""


@dataclass(frozen=True, slots=True)
class PlottedLine:
    """A broken line; dash: SVG's stroke-dasharray, empty for a solid line."""

    points: Points
    colour: str
    width: float = 1.4
    dash: str = ""


@dataclass(frozen=True, slots=True)
class Area:
    """A filled polygon."""

    points: Points
    colour: str
    opacity: float = 1.0


@dataclass(frozen=True, slots=True)
class Dot:
    """A marker; shape: o, s (square), D (diamond), ^ or v; hollow: only its outline."""

    at: tuple[float, float]
    shape: str
    colour: str
    radius: float = 3.5
    hollow: bool = False


@dataclass(frozen=True, slots=True)
class Word:
    """Text; anchor: which of its start, middle or end is at the point; upright: turned by a
    quarter, read from below.
    """

    at: tuple[float, float]
    text: str
    anchor: str = "start"
    size: float = 11.0
    bold: bool = False
    upright: bool = False
    colour: str = "#1c1f23"


Mark = PlottedLine | Area | Dot | Word


@dataclass(frozen=True, slots=True)
class Drawing:
    """Marks on a sheet, width and height in pixels; title: its content, for readers who cannot see
    it.
    """

    width: float
    height: float
    marks: tuple[Mark, ...]
    title: str = ""


@dataclass(frozen=True, slots=True)
class Plot:
    """A figure ready for a page.

    name : of its file
    alt : its content, in words
    panels : its drawings, in order
    across : number of drawings side by side in the file; a page uses as many as there is room for
    """

    name: str
    title: str
    alt: str
    panels: tuple[Drawing, ...]
    across: int = 2

    @property
    def svg(self) -> str:
        """Return the whole figure as an SVG file."""
        return (
            '<?xml version="1.0" encoding="utf-8"?>\n'
            + svg_text(arranged(self.panels, self.across), self.alt)
            + "\n"
        )


def thinned(points: Sequence[Any], most: int = MOST_POINTS) -> Sequence[Any]:
    """Return at most `most` of some points, evenly spaced in their order."""
    return points[:: -(-len(points) // most)] if len(points) > most else points


def thinned_words(shown: int, count: int) -> str:
    """Return a sentence for a figure that does not show all points; "" where it does."""
    return f" Shown are {shown} of {count}, evenly chosen." if shown < count else ""


def arranged(panels: Sequence[Drawing], across: int) -> Drawing:
    """Return drawings as one, `across` in a row."""
    marks: list[Mark] = []
    top, widest = 0.0, 0.0
    for first in range(0, len(panels), across):
        left, row = 0.0, panels[first : first + across]
        for panel in row:
            marks += (_moved(mark, left, top) for mark in panel.marks)
            left += panel.width + GAP
        widest = max(widest, left - GAP)
        top += max(panel.height for panel in row) + GAP
    return Drawing(widest, top - GAP, tuple(marks))


def svg_text(drawing: Drawing, label: str) -> str:
    """Return a drawing as an SVG element of its own size, with a label for readers who cannot see
    it.
    """
    width, height = f"{drawing.width:g}", f"{drawing.height:g}"
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
        f'role="img" aria-label="{escape(label)}" font-family="{FONT}">'
    )
    return head + "".join(map(_element, drawing.marks)) + "</svg>"


def _moved(mark: Mark, right: float, down: float) -> Mark:
    if isinstance(mark, PlottedLine):
        return PlottedLine(_shifted(mark.points, right, down), mark.colour, mark.width, mark.dash)
    if isinstance(mark, Area):
        return Area(_shifted(mark.points, right, down), mark.colour, mark.opacity)
    at = (mark.at[0] + right, mark.at[1] + down)
    if isinstance(mark, Dot):
        return Dot(at, mark.shape, mark.colour, mark.radius, mark.hollow)
    return Word(at, mark.text, mark.anchor, mark.size, mark.bold, mark.upright, mark.colour)


def _shifted(points: Points, right: float, down: float) -> Points:
    return [(x + right, y + down) for x, y in points]


def outline(dot: Dot) -> Points:
    """Return the corners of a dot that is no circle."""
    (x, y), r = dot.at, dot.radius
    if dot.shape == "s":
        return ((x - r, y - r), (x + r, y - r), (x + r, y + r), (x - r, y + r))
    if dot.shape == "D":
        return ((x, y - 1.3 * r), (x + 1.3 * r, y), (x, y + 1.3 * r), (x - 1.3 * r, y))
    up = r if dot.shape == "^" else -r
    return ((x - r, y + up), (x + r, y + up), (x, y - 1.2 * up))


def _element(mark: Mark) -> str:
    if isinstance(mark, PlottedLine):
        dash = f' stroke-dasharray="{mark.dash}"' if mark.dash else ""
        return (
            f'<path d="{_path(mark.points)}" fill="none" stroke="{mark.colour}" stroke-width="{mark.width:g}"{dash} '
            'stroke-linejoin="round"/>'
        )
    if isinstance(mark, Area):
        opacity = f' fill-opacity="{mark.opacity:g}"' if mark.opacity < 1 else ""
        return f'<path d="{_path(mark.points)}Z" fill="{mark.colour}"{opacity}/>'
    x, y = (_place(value) for value in mark.at)
    if isinstance(mark, Word):
        turn = f' transform="rotate(-90 {x} {y})"' if mark.upright else ""
        bold = ' font-weight="600"' if mark.bold else ""
        anchor = "" if mark.anchor == "start" else f' text-anchor="{mark.anchor}"'
        return (
            f'<text x="{x}" y="{y}" font-size="{mark.size:g}" fill="{mark.colour}"{anchor}{bold}{turn}>'
            f"{escape(mark.text)}</text>"
        )
    paint = f'fill="#fff" stroke="{mark.colour}"' if mark.hollow else f'fill="{mark.colour}"'
    if mark.shape == "o":
        return f'<circle cx="{x}" cy="{y}" r="{mark.radius:g}" {paint}/>'
    return f'<path d="{_path(outline(mark))}Z" {paint}/>'


def _path(points: Iterable[tuple[float, float]]) -> str:
    return "M" + "L".join(f"{_place(x)} {_place(y)}" for x, y in points)


def _place(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0")
