"""Units that a file states in its own words, beside those of the mapping: used, or contradicted."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from daq.formats.column import FileColumn
from daq.formats.wave import FormatError
from rig.importing.mapping import (
    ACCELERATION_UNITS,
    FORCE_UNITS,
    TIME_UNITS,
    VOLTS,
    AccelerationColumn,
    ForceColumn,
    TimeColumn,
)

__all__ = ["UnitFound", "channel_unit", "time_unit", "unit_in_words"]

NOTHING = {
    "",
    "-",
    "--",
    "none",
    "eu",
    "n/a",
    "na",
    "unknown",
    "?",
    "1",
    "a.u.",
    "no unit",
    "none units",
}
"""Words for no statement at all."""

WORDS: Mapping[str, str] = {
    "newton": "N", "newtons": "N", "kilonewton": "kN", "kilonewtons": "kN", "millinewton": "mN",
    "lb": "lbf", "lbs": "lbf", "pound": "lbf", "pounds": "lbf", "kp": "kgf",
    "m/s/s": "m/s^2", "m/s2": "m/s^2", "ms^-2": "m/s^2", "ms-2": "m/s^2", "m/sec^2": "m/s^2", "m/sec2": "m/s^2",
    "mps2": "m/s^2", "mm/s2": "mm/s^2", "mms^-2": "mm/s^2", "cm/s2": "cm/s^2", "gal": "cm/s^2",
    "in/s2": "in/s^2", "ft/s2": "ft/s^2", "gn": "g", "g_n": "g", "g0": "g", "gs": "g", "gravity": "g", "gravities": "g",
    "volt": "V", "volts": "V", "millivolt": "mV", "millivolts": "mV",
    "sec": "s", "secs": "s", "second": "s", "seconds": "s", "sek": "s", "msec": "ms", "millisecond": "ms",
    "milliseconds": "ms", "usec": "us", "microseconds": "us", "nanoseconds": "ns",
}  # fmt: skip
"""Other words for units, in small letters, without blanks."""

OTHERS = {
    "Pa", "kPa", "MPa", "bar", "m", "mm", "um", "nm", "cm", "in", "ft", "m/s", "mm/s", "in/s", "kg", "A", "mA", "Hz",
    "kHz", "rad", "deg", "%", "C", "degC", "K", "rpm", "strain", "ue", "um/m", "Nm", "J", "W", "pC", "dB", "bit", "bits",
    "count", "counts", "LSB", "codes",
}  # fmt: skip
"""Units of other quantities."""


@dataclass(frozen=True)
class UnitFound:
    """The unit of a channel. told: how it came from the file, "" otherwise. doubt: whether the file
    may mean another one.
    """

    unit: str
    told: str = ""
    doubt: bool = False


def unit_in_words(words: str) -> str | None:
    """Return a file's unit in the mapping's spelling; "" where it says none, None for a word that is
    no known unit.
    """
    bare = re.sub(r"[\s\u00b7*]+", "", words.replace("**", "^").replace("\u00b2", "^2"))
    bare = bare.replace("\u00b5", "u").replace("\u03bc", "u").replace("\u207b^2", "^-2")
    bare = bare.strip("[](){}")
    if bare.lower() in NOTHING or words.strip().lower() in NOTHING:
        return ""
    known = {*FORCE_UNITS, *ACCELERATION_UNITS, *TIME_UNITS, *OTHERS}
    if bare in known:
        return bare
    return WORDS.get(bare.lower()) or {"G": "g", "mG": "mg", "KN": "kN", "Mg": None}.get(bare)


def channel_unit(
    file: Path, name: str, column: ForceColumn | AccelerationColumn, found: FileColumn
) -> UnitFound:
    """Return the unit of force or acceleration: the mapping's, the file's, or SI where neither
    states one.

    Raises FormatError where they differ, the file states a unit of another quantity, or one that
    needs a sensitivity.
    """
    units = FORCE_UNITS if name == "force" else ACCELERATION_UNITS
    return _unit(file, name, next(iter(units)), units, column.unit, column.overrule, found)


def time_unit(file: Path, column: TimeColumn, found: FileColumn) -> UnitFound:
    """Return the unit of a time column; see `channel_unit`."""
    return _unit(file, "time", "s", TIME_UNITS, column.unit, False, found)


def _unit(
    file: Path, name: str, default: str, units: Mapping[str, float], stated: str | None, overrule: bool,
    found: FileColumn,
) -> UnitFound:  # fmt: skip
    allowed = ", ".join(units)
    told = unit_in_words(found.unit)
    where = f"{file}: {found.unit_at or 'the file'} gives {name} in {found.unit!r}"
    if told == "":
        skipped = unit_in_words(found.skipped_unit)
        doubt = stated is None and bool(skipped) and skipped != default
        return UnitFound(stated or default, doubt=doubt)
    if stated is not None and overrule:
        return UnitFound(stated, f"{found.unit_at} says {found.unit}; overruled")
    if told is None:
        if stated is not None:
            return UnitFound(stated)
        raise FormatError(
            f"{where}, no unit that is known: write `{name}: {{unit: ...}}` ({allowed})"
        )
    if told not in units:
        raise FormatError(
            f"{where}, which is no unit of {name}: choose another channel, or write `{name}: {{unit: ..., overrule: true}}` "
            f"({allowed})"
        )
    if stated is not None and stated != told:
        raise FormatError(
            f"{where}, the mapping says {name}.unit: {stated}; correct one of them, or write `overrule: true` where the "
            "mapping is right"
        )
    if stated is None and told in VOLTS:
        raise FormatError(
            f"{where}: write `{name}: {{unit: {told}, sensitivity: ...}}`, the sensitivity from the certificate"
        )
    return UnitFound(told, "" if stated else f"{found.unit} by {found.unit_at}")
