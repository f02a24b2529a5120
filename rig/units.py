"""Quantities: text with a unit to SI numbers and back, exactly; as shapes of a document, with unit
and range.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import Any

from daq.documents.notes import Notes, bare

GRAVITY = 9.80665
"""Standard gravity, m/s^2, exact by definition (3rd CGPM, 1901)."""

_G = Decimal("9.80665")
_DEGREE = Decimal("0.01745329251994329576923690768488612713")
_DEGREE_PER_KHZ = Decimal(1) / Decimal(360000)
_ONE, _MILLI, _MICRO, _KILO = Decimal(1), Decimal("0.001"), Decimal("0.000001"), Decimal(1000)

UNITS: Mapping[str, Mapping[str, Decimal]] = {
    "number": {"": _ONE, "%": Decimal("0.01"), "ppm": _MICRO},
    "ppm": {"ppm": _ONE},
    "cycles": {"cycles": _ONE, "cycle": _ONE},
    "samples": {"samples": _ONE, "sample": _ONE},
    "length": {"m": _ONE, "mm": _MILLI, "cm": Decimal("0.01"), "um": _MICRO},
    "mass": {"kg": _ONE, "g": _MILLI},
    "time": {"s": _ONE, "ms": _MILLI, "us": _MICRO},
    "delay": {"s": _ONE, "us": _MICRO, "ns": _MICRO * _MILLI, "deg/kHz": _DEGREE_PER_KHZ},
    "frequency": {"Hz": _ONE, "kHz": _KILO},
    "rate": {"S/s": _ONE, "kS/s": _KILO, "Hz": _ONE, "kHz": _KILO},
    "force": {"N": _ONE, "kN": _KILO, "mN": _MILLI},
    "voltage": {"V": _ONE, "mV": _MILLI, "uV": _MICRO},
    "current": {"A": _ONE, "mA": _MILLI},
    "velocity": {"m/s": _ONE, "mm/s": _MILLI},
    "acceleration": {"m/s^2": _ONE, "m/s2": _ONE, "g": _G, "mg": _G * _MILLI},
    "stiffness": {"N/m": _ONE, "kN/m": _KILO},
    "damping": {"N s/m": _ONE, "N*s/m": _ONE},
    "quadratic damping": {"N s^2/m^2": _ONE, "N*s^2/m^2": _ONE},
    "density": {"kg/m^3": _ONE, "kg/m3": _ONE, "g/cm^3": _KILO, "g/cm3": _KILO},
    "pressure": {"Pa": _ONE, "kPa": _KILO, "MPa": Decimal(10) ** 6, "GPa": Decimal(10) ** 9},
    "angle": {"rad": _ONE, "mrad": _MILLI, "deg": _DEGREE},
    "force constant": {"N/A": _ONE},
    "resistance": {"ohm": _ONE, "kohm": _KILO},
    "inductance": {"H": _ONE, "mH": _MILLI, "uH": _MICRO},
    "force noise": {"N/rtHz": _ONE},
    "acceleration noise": {"m/s^2/rtHz": _ONE, "ug/rtHz": _G * _MICRO},
    "force sensitivity": {"V/N": _ONE, "mV/N": _MILLI},
    "voltage sensitivity": {"V/V": _ONE, "mV/V": _MILLI},
    "current sensitivity": {"V/A": _ONE, "mV/A": _MILLI},
    "acceleration sensitivity": {
        "V/(m/s^2)": _ONE,
        "mV/(m/s^2)": _MILLI,
        "V/g": _ONE / _G,
        "mV/g": _MILLI / _G,
    },
}
"""Dimension -> unit -> its size in SI. The SI unit is the first one; a plain number is in that
unit.
"""

_QUANTITY = re.compile(
    r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\d\s].{0,20})?\s*", re.ASCII
)
_LONGEST_TEXT = 64

LEAST_PER_CENT = 2.0
"""Number from which a fraction out of range may have been meant in per cent; 1.2 was not."""


SMALLEST = 1e-60
"""Smallest number but 0, SI: products of a few such are numbers still."""

_ANY = r"[-+]?(?:\d+\.?\d*|\.\d+)"
_NOT_NEGATIVE = r"(?:\+?(?:\d+\.?\d*|\.\d+)|-(?:0+\.?0*|\.0+))"
_POSITIVE = r"\+?(?=[\d.]*[1-9])(?:\d+\.?\d*|\.\d+)"


@dataclass(frozen=True)
class Quantity:
    """What a number means and may be: `least` <= value <= `most`, or `least` < value where `above`;
    a whole number, null, or one of some words where it says so. It is written as a plain number in
    SI, or as text with a unit."""

    dimension: str = "number"
    least: float = -math.inf
    most: float = math.inf
    above: bool = False
    whole: bool = False
    null: bool = False
    words: tuple[str, ...] = ()

    def holds(self, value: float) -> bool:
        """Return whether a value (SI) is in the range."""
        return (value > self.least if self.above else value >= self.least) and value <= self.most

    def __str__(self) -> str:
        """Return the allowed range in words, with the units: "above 0 m, at most 20 m (units m, mm,
        cm, um)".
        """
        if self.whole:
            return ", ".join(part for part in ("a whole number", self.range()) if part)
        return ", or ".join(
            [f"{self.range() or 'a number'} ({allowed_units(self.dimension)})", *self.words]
        )

    def range(self) -> str:
        """Return the allowed range in words, "" if every number is allowed."""
        parts = []
        if math.isfinite(self.least):
            parts.append(
                f"{'above' if self.above else 'at least'} {_short(self.least, self.dimension)}"
            )
        if math.isfinite(self.most):
            parts.append(f"at most {_short(self.most, self.dimension)}")
        return ", ".join(parts)

    def fitted(self, whole: bool, null: bool, words: tuple[str, ...]) -> Quantity:
        """Return the quantity for the type of a field, such as `float | Literal["none"] | None`."""
        return replace(self, whole=whole, null=null, words=words)

    def read(self, node: Any, path: str, notes: Notes) -> float | int | str | None:
        """Return the SI number of a node, a word, or None."""
        value = written = bare(node)
        if value in self.words or (value is None and self.null):
            return str(value) if value is not None else None
        if isinstance(written, str):
            if self.words and written.isalpha():
                raise notes.refuse(node, path, self, notes.near(written, self.words))
            try:
                value = parse_quantity(written, self.dimension)
            except UnitError as error:
                raise notes.refuse(node, path, self if self.whole else error) from error
        if not isinstance(value, int | float) or isinstance(value, bool):
            raise notes.refuse(node, path, self)
        if not self.holds(value):
            raise notes.refuse(
                node,
                path,
                self,
                "" if isinstance(written, str) else suggest_unit(float(value), self),
            )
        if 0 < abs(value) < SMALLEST:
            raise notes.refuse(node, path, f"{self}; 0, or at least {SMALLEST:g} in size")
        if self.whole and value != int(value):
            raise notes.refuse(node, path, self)
        return int(value) if self.whole else float(value) + 0.0

    def plain(self, value: Any) -> Any:
        """Return a number with its unit, such that `read` gives it back."""
        if value is None or isinstance(value, str):
            return value
        value += 0 if isinstance(value, int) else 0.0  # a minus zero is a zero
        return value if self.dimension == "number" else format_quantity(value, self.dimension)

    def schema(self, _kinds: dict[str, Any]) -> dict[str, Any]:
        """Return the schema: a plain number in its range, or text with a unit.

        Of the number in a text only the sign is checked.
        """
        number: dict[str, Any] = {"type": "integer" if self.whole else "number"}
        if math.isfinite(self.least):
            number["exclusiveMinimum" if self.above else "minimum"] = self.least
        if math.isfinite(self.most):
            number["maximum"] = self.most
        positive = self.least > 0 or (self.least == 0 and self.above)
        digits = _POSITIVE if positive else _NOT_NEGATIVE if self.least == 0 else _ANY
        units = "|".join(
            _escaped(unit) for unit in sorted(UNITS[self.dimension], key=len, reverse=True)
        )
        pattern = rf"^\s*{digits}(?:[eE][-+]?\d+)?\s*(?:{units})\s*$"
        forms = [number, {"type": "string", "pattern": pattern, "maxLength": _LONGEST_TEXT}]
        forms += [{"enum": list(self.words)}] if self.words else []
        return {
            "description": str(self),
            "anyOf": forms + ([{"type": "null"}] if self.null else []),
        }


class UnitError(ValueError):
    """A text that is not a quantity of the required dimension; the message names the units that
    are.
    """


def unit_of(dimension: str) -> str:
    """Return the SI unit of a dimension, "" for plain numbers."""
    return next(iter(UNITS[dimension]))


def allowed_units(dimension: str) -> str:
    """Return the units of a dimension, for messages."""
    if dimension == "number":
        return "a plain number or %"
    return f"units {', '.join(UNITS[dimension])}"


def parse_quantity(text: str, dimension: str) -> float:
    """Return the SI value of a text such as "150 mm", correctly rounded.

    Raises UnitError for text that is not a number, for a missing or foreign unit, and for numbers
    beyond the floating-point range.
    """
    match = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST_TEXT else None
    if match is None:
        raise UnitError(f"a number with a unit ({allowed_units(dimension)})")
    digits, unit = match.group(1), " ".join((match.group(2) or "").split())
    scale = UNITS[dimension].get(unit)
    if scale is None:
        raise UnitError(f"a number with a unit ({allowed_units(dimension)})")
    value = float(digits)
    # Decimal arithmetic: one rounding at the end, so that 150 mm and 0.15 m are the same number.
    if value and math.isfinite(value) and scale != 1:
        value = float(Decimal(digits) * scale)
    if not math.isfinite(value):
        raise UnitError("a finite number")
    return value


def format_quantity(value: float, dimension: str) -> str:
    """Return a text with the SI unit that parse_quantity reads back to the same number, bit for
    bit.
    """
    return f"{value!r} {unit_of(dimension)}".rstrip()


def suggest_unit(value: float, quantity: Quantity) -> str:
    """Return a hint if a plain number out of range makes sense in another unit: 150 m, "did you
    mean 150 mm?".
    """
    if quantity.dimension == "number" and (quantity.most > 1 or abs(value) < LEAST_PER_CENT):
        return ""  # a count or a coefficient, or a share a little above one: per cent of it are no help
    for unit, scale in UNITS[quantity.dimension].items():
        if scale < 1 and math.isfinite(value) and quantity.holds(value * float(scale)):
            plain = (
                f"{value:g} is {_short(value, quantity.dimension)}; "
                if unit_of(quantity.dimension)
                else ""
            )
            return f"{plain}did you mean {value:g} {unit}?"
    return ""


def _short(value: float, dimension: str) -> str:
    digits = str(value) if isinstance(value, int) else f"{value:g}"
    return f"{digits} {unit_of(dimension)}".rstrip()


def _escaped(unit: str) -> str:
    """Return a unit as a regular expression that JavaScript and Python read alike."""
    return "".join(r"\s+" if c == " " else f"\\{c}" if c in "^*/()" else c for c in unit)
