"""A panel with two axes, which turns data into the marks of a drawing."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

from analysis.report.figures.drawing import Area, Dot, Drawing, Mark, PlottedLine, Word

__all__ = [
    "BLUE",
    "GREEN",
    "GREY",
    "INK",
    "MARKERS",
    "ORANGE",
    "SERIES",
    "Panel",
    "Scale",
    "legend",
    "linear",
    "logarithmic",
    "signed_logarithmic",
    "tick",
]

# Okabe and Ito's palette, safe for the colour-blind
BLUE, ORANGE, GREEN, GREY, INK = "#0072b2", "#d55e00", "#007a5a", "#8a8a8a", "#1c1f23"
SERIES = (BLUE, "#b87700", GREEN, "#b3578a", "#3a93c9", "#000000", ORANGE, "#767622")
MARKERS = "osD^v"

WIDTH, HEIGHT = 356.0, 236.0  # of a panel, pixels: the width of a phone
LEFT, RIGHT, TOP, BOTTOM = 66.0, 8.0, 24.0, 40.0  # margins around the frame
NEAR = 20.0  # bound of the linear part of a signed logarithmic axis
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)  # between ticks, times a power of ten


@dataclass(frozen=True, slots=True)
class Scale:
    """An axis.

    low, high : its ends
    place : function from a value to 0..1
    ticks : the values that are labelled
    """

    low: float
    high: float
    place: Callable[[float], float]
    ticks: tuple[float, ...]


def linear(values: Iterable[float], zero: bool = False, most: int = 6) -> Scale:
    """Return a linear axis around values, a little wider.

    zero: it begins or ends at 0 where all values are on one side.
    """
    low, high = _ends(values)
    if zero:
        low, high = min(low, 0.0), max(high, 0.0)
    if high <= low:
        half = abs(low) / 2 or 1.0
        low, high = low - half, high + half
    room = 0.05 * (high - low)
    low, high = (
        low - (room if not zero or low < 0 else 0),
        high + (room if not zero or high > 0 else 0),
    )
    return Scale(
        low, high, lambda value: (value - low) / (high - low), _round_values(low, high, most)
    )


def logarithmic(values: Iterable[float]) -> Scale:
    """Return a logarithmic axis around positive values, a little wider."""
    low, high = _ends(value for value in values if value > 0)
    low, high = (low, high) if low > 0 else (0.1, 10.0)
    room = 1.15 if high > 1.5 * low else 3.0  # a single value: wide enough for ticks beside it
    low, high = low / room, high * room
    first, decades = math.log(low), math.log(high) - math.log(low)
    found = [
        digit * 10.0**power
        for power in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
        for digit in (1, 2, 5)
    ]
    within = [value for value in found if low <= value <= high]
    tens = [value for value in within if f"{value:e}".startswith("1.")]
    if len(within) <= 6:
        ticks = within
    elif len(tens) <= 7:
        ticks = tens
    else:
        ticks = tens[:: -(-len(tens) // 6)]
    return Scale(
        low, high, lambda value: (math.log(max(value, low / 1e3)) - first) / decades, tuple(ticks)
    )


def signed_logarithmic(values: Iterable[float]) -> Scale:
    """Return an axis that is linear within ±NEAR and logarithmic beyond.

    The offset of a tiny energy can be thousands of per cent.
    """
    low, high = _ends(values)
    low, high = min(low, -NEAR / 2), max(high, NEAR / 2)
    if low > -NEAR and high < NEAR:
        return linear((low, high))

    def bent(value: float) -> float:
        return (
            value / NEAR
            if abs(value) <= NEAR
            else math.copysign(1 + math.log10(abs(value) / NEAR), value)
        )

    first, last = bent(low) - 0.1, bent(high) + 0.1
    known = [
        0.0,
        *(sign * value for sign in (1, -1) for value in (10.0, 20.0, 100.0, 1e3, 1e4, 1e5, 1e6)),
    ]
    ticks = sorted(value for value in known if first <= bent(value) <= last)
    return Scale(low, high, lambda value: (bent(value) - first) / (last - first), tuple(ticks))


def _ends(values: Iterable[float]) -> tuple[float, float]:
    """Return the least and the largest finite value; (0, 1) without any."""
    known = [value for value in values if math.isfinite(value)]
    return (min(known), max(known)) if known else (0.0, 1.0)


def _round_values(low: float, high: float, most: int) -> tuple[float, ...]:
    """Return at most about `most` round values from low to high."""
    rough = (high - low) / most
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(digit * power for digit in STEPS if digit * power >= rough * (1 - 1e-9))
    first = math.ceil(low / step - 1e-9)
    return tuple(step * number for number in range(first, math.floor(high / step + 1e-9) + 1))


@dataclass
class Panel:
    """A panel in the making: its methods add marks, and `drawing` returns them on their frame."""

    x: Scale
    y: Scale
    x_label: str
    y_label: str
    title: str = ""
    height: float = HEIGHT
    names: Sequence[str] = ()  # tick labels of x = 0, 1, 2, ... instead of numbers
    marks: list[Mark] = field(default_factory=list)

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Return the pixel position of a point, kept within the frame."""
        across, up = (min(max(s.place(v), 0.0), 1.0) for s, v in ((self.x, x), (self.y, y)))
        return LEFT + across * (WIDTH - LEFT - RIGHT), self.height - BOTTOM - up * (
            self.height - TOP - BOTTOM
        )

    def line(
        self,
        x: Sequence[float],
        y: Sequence[float],
        colour: str,
        width: float = 1.6,
        dash: str = "",
    ) -> None:
        """Draw a broken line through points; a single point becomes a short line."""
        self.marks.append(
            PlottedLine(
                self._widened([self.at(*point) for point in zip(x, y, strict=True)]),
                colour,
                width,
                dash,
            )
        )

    def band(
        self,
        x: Sequence[float],
        low: Sequence[float],
        high: Sequence[float],
        colour: str,
        opacity: float,
    ) -> None:
        """Draw the area between two lines; a single point becomes a bar."""
        below, above = (
            self._widened([self.at(*p) for p in zip(x, y, strict=True)]) for y in (low, high)
        )
        self.marks.append(Area([*below, *reversed(above)], colour, opacity))

    def _widened(self, points: list[tuple[float, float]]) -> list[tuple[float, float]]:
        if len(points) != 1:
            return points
        x, y = points[0]
        return [(x - 12, y), (x + 12, y)]

    def level(self, y: float, colour: str, width: float = 1.2, dash: str = "") -> None:
        """Draw a horizontal line across the frame."""
        self.line((self.x.low, self.x.high), (y, y), colour, width, dash)

    def spread(self, low: float, high: float, colour: str, opacity: float) -> None:
        """Draw a horizontal band across the frame."""
        self.band((self.x.low, self.x.high), (low, low), (high, high), colour, opacity)

    def bars(
        self,
        x: Sequence[float],
        y: Sequence[float],
        U: Sequence[float],
        colour: str,
        shape: str = "o",
    ) -> None:
        """Draw dots with bars of ±U."""
        for each, value, half in zip(x, y, U, strict=True):
            (across, low), (_, high) = self.at(each, value - half), self.at(each, value + half)
            if low - high > 2:
                self.marks.append(PlottedLine(((across, low), (across, high)), colour, 1.2))
                self.marks += [
                    PlottedLine(((across - 3, end), (across + 3, end)), colour, 1.2)
                    for end in (low, high)
                ]
            self.marks.append(Dot(self.at(each, value), shape, colour))

    def dots(self, x: Sequence[float], y: Sequence[float], colour: str, shape: str = "o", radius: float = 2.0,
             hollow: bool = True) -> None:  # fmt: skip
        """Draw small dots: single runs."""
        self.marks += [
            Dot(self.at(*p), shape, colour, radius, hollow) for p in zip(x, y, strict=True)
        ]

    def column(self, x: float, low: float, high: float, colour: str, width: float = 0.6) -> None:
        """Draw a column of a bar chart from low to high."""
        (left, top), (right, bottom) = self.at(x - width / 2, high), self.at(x + width / 2, low)
        self.marks.append(
            Area(((left, top), (right, top), (right, bottom), (left, bottom)), colour)
        )

    def word(
        self,
        x: float,
        y: float,
        text: str,
        anchor: str = "middle",
        up: float = 6.0,
        colour: str = INK,
    ) -> None:
        """Write text at a point of the data, `up` pixels above it."""
        across, down = self.at(x, y)
        self.marks.append(Word((across, down - up), text, anchor, 10.5, colour=colour))

    def drawing(self) -> Drawing:
        """Return the panel with its frame, ticks and labels."""
        low, base = LEFT, self.height - BOTTOM
        marks: list[Mark] = [Word((LEFT, 15.0), self.title, bold=True)] if self.title else []
        for value in self.y.ticks:
            down = self.at(self.x.low, value)[1]
            marks += [PlottedLine(((low, down), (WIDTH - RIGHT, down)), "#e4e4e4", 0.7),
                      Word((low - 5, down + 4), tick(value), "end")]  # fmt: skip
        named: list[tuple[float, str]] = [(place, text) for place, text in enumerate(self.names)]
        named = named or [(value, tick(value)) for value in self.x.ticks]
        for value, text in named:
            across = self.at(value, self.y.low)[0]
            if not self.names:
                marks.append(PlottedLine(((across, TOP), (across, base)), "#e4e4e4", 0.7))
            marks.append(Word((across, base + 14), text, "middle"))
        marks += [
            PlottedLine(((low, TOP), (low, base), (WIDTH - RIGHT, base)), INK, 1.0),
            Word(((low + WIDTH - RIGHT) / 2, self.height - 8), self.x_label, "middle"),
            Word((13.0, (TOP + base) / 2), self.y_label, "middle", upright=True),
        ]
        return Drawing(WIDTH, self.height, (*marks, *self.marks), self.title)


def tick(value: float) -> str:
    """Return the label of a tick: short, with a real minus, an exponent only for very large or
    small values.
    """
    value = 0.0 if abs(value) < 1e-12 else value
    if value and not 1e-3 <= abs(value) < 1e6:
        digits, power = f"{value:.3e}".split("e")
        digits = digits.rstrip("0").rstrip(".")
        ten = "10" + str(int(power)).translate(RAISED)
        text = {"1": ten, "-1": f"-{ten}"}.get(digits, f"{digits}·{ten}")
    else:
        text = f"{value:.0f}" if abs(value) >= 1e4 else f"{value:.4g}"
    return text.replace("-", "−")


def legend(entries: Sequence[tuple[str, str, str]]) -> Drawing:
    """Return a legend of lines, bands and dots.

    entries: (kind, colour, words), kind a marker's shape, `line`, `dash`, `run` or `band`.
    """
    marks: list[Mark] = []
    for row, (kind, colour, words) in enumerate(entries):
        y = 12.0 + 18 * row
        if kind == "band":
            marks.append(Area(((2, y - 5), (26, y - 5), (26, y + 5), (2, y + 5)), colour, 0.3))
        elif kind in ("line", "dash"):
            marks.append(
                PlottedLine(((2, y), (26, y)), colour, 1.8, "5 3" if kind == "dash" else "")
            )
        elif kind == "run":
            marks.append(Dot((14, y), "o", colour, 2.0, True))
        else:
            marks += [
                PlottedLine(((14, y - 7), (14, y + 7)), colour, 1.2),
                Dot((14, y), kind, colour),
            ]
        marks.append(Word((34, y + 4), words))
    return Drawing(WIDTH, 18.0 * len(entries) + 6, tuple(marks), "legend")
