"""Words of text files: numbers in any country's writing, times of day, headers with a unit."""

import re

__all__ = ["UNIT", "UNIT_WORD", "clean", "is_clock", "stem_of", "unit_in"]

PLAIN = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?|[-+]?(?:nan|inf(?:inity)?)", re.I)
CLOCK = re.compile(
    r"(?:.*[\sT])?\d{1,2}:\d{2}:\d{2}(?:[.,]\d+)?\s*(?:[AaPp][Mm]|Z|[-+]\d{2}:?\d{2})?"
)
GROUPED = r"[-+]?[1-9]\d{0,2}(?:%s\d{3})+"
BLANKS = " \u00a0\u202f'\u2019"  # signs between thousands beside comma and point
UNIT = re.compile(r"(?P<name>.*?)\s*(?:\[(?P<a>[^\]]*)\]|\((?P<b>[^)]*)\)|<(?P<c>[^>]*)>)\s*")
SLASHED = re.compile(
    r"(?P<name>.+?)\s*(?:/|,| in )\s*(?P<a>k?N|mN|lbf|m?g|[mun\u00b5\u03bc]?s|m?V|[cm]?m/s(?:\^?2|\u00b2|\*\*2))"
)
SUFFIXED = re.compile(r"(?P<name>t|time|timestamp|zeit)_(?P<a>s|ms|us|ns)", re.I)
UNIT_WORD = re.compile(
    r"-|k?N|mN|lbf|m?g|[mun\u00b5\u03bc]?s|m?V|[cm]?m/s(?:\^?2|\u00b2|\*\*2)|sec|Hz"
)


def clean(word: str, decimal: str) -> str | None:
    """Return a number as Python writes it, without its thousands' signs; None for no number."""
    if decimal == ".":
        if PLAIN.fullmatch(word):
            return word
        others = f"[{BLANKS},]"
    else:
        if "." not in word and PLAIN.fullmatch(word.replace(",", ".")):
            return word.replace(",", ".")
        others = f"[{BLANKS}.]"
    whole, point, rest = word.partition(decimal)
    if not re.fullmatch(GROUPED % others, whole):
        return None
    bare = re.sub(others, "", whole) + ("." if point else "") + rest
    return bare if PLAIN.fullmatch(bare) else None


def is_clock(word: str) -> bool:
    """Return whether a word tells a time of day, with or without a date."""
    return CLOCK.fullmatch(word) is not None


def unit_in(header: str) -> str:
    """Return the unit in a header: "force [N]", "Kraft / N", "time_ms"; "" for none."""
    for form in (UNIT, SLASHED, SUFFIXED):
        told = form.fullmatch(header)
        if told:
            return next(
                (part.strip() for key, part in told.groupdict().items() if key != "name" and part),
                "",
            )
    return ""


def stem_of(header: str) -> str:
    """Return a header without the unit in it."""
    told = UNIT.fullmatch(header)
    return told.group("name").strip() if told else header
