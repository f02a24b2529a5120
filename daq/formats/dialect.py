"""The layout of a text file of numbers: encoding, delimiter, decimal sign, header, units; found in
its lines unless it is stated.
"""

import csv
import io
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from daq.formats.wave import FormatError
from daq.formats.words import UNIT_WORD, clean, is_clock, unit_in
from daq.regular_files import open_regular

__all__ = ["CsvStyle", "Layout", "layout_of", "lines_of", "split", "tail_of"]

HEADER_LINES = 200  # lines searched for the layout
LONGEST_LINE = 2**20  # characters of a line
TAIL = 2**14  # bytes read at the end of a file
DELIMITERS = ("\t", ";", "|", ",", " ")  # tried in this order; " " is any run of blanks
LABVIEW, END_OF_HEADER = "LabVIEW Measurement", "***End_of_Header***"


@dataclass(frozen=True)
class CsvStyle:
    """What is stated of a text file; "" and None: found in its lines. skip: lines left out before
    the header or the numbers.
    """

    delimiter: str = ""
    decimal: str = ""
    skip: int | None = None


@dataclass(frozen=True)
class Layout:
    """How a text file is laid out.

    first : line of the first numbers, counted from 1
    names, units : header words and units of the columns, "" for none; units_at: where they stand
    skipped : units that stand in lines which the mapping leaves out
    starts, steps : of the columns' own time scales as a header tells them, s; None for none
    width : number of columns
    quoted : fields stand in quotes
    """

    encoding: str
    delimiter: str
    decimal: str
    first: int
    names: tuple[str, ...]
    units: tuple[str, ...]
    units_at: str
    width: int
    quoted: bool
    rows: tuple[tuple[str, ...], ...]
    skipped: tuple[str, ...] = ()
    starts: tuple[float, ...] = ()
    steps: tuple[float, ...] = ()


def encoding_of(path: Path) -> str:
    """Return the encoding of a text file: by its byte order mark, else by where zeros stand; UTF-8
    where it is that, else Windows' Latin-1.
    """
    with open_regular(path) as file:
        head = file.read(2**16)
    if head[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    if b"\0" in head:
        # Of letters and digits in UTF-16 every other byte is 0.
        odd, even = head[1::2].count(0), head[::2].count(0)
        if max(odd, even) > 0.9 * len(head) / 2 and min(odd, even) < 0.1 * len(head) / 2:
            return "utf-16-le" if odd > even else "utf-16-be"
        raise FormatError(f"{path} is no text: it holds zero bytes")
    try:
        # A letter of several bytes may be cut at the end.
        head.decode("utf-8") if len(head) < 2**16 else head[:-4].decode("utf-8", "strict")
    except UnicodeDecodeError as error:
        return "cp1252" if error.start < len(head) - 8 else "utf-8-sig"
    return "utf-8-sig"


def lines_of(path: Path, encoding: str) -> Iterator[str]:
    """Yield the lines of a text file. FormatError for one that is too long."""
    with io.TextIOWrapper(open_regular(path), encoding=encoding, errors="replace") as file:
        number = 0
        while line := file.readline(LONGEST_LINE + 1):
            number += 1
            if len(line) > LONGEST_LINE:
                raise FormatError(f"{path}: line {number} has more than {LONGEST_LINE} characters")
            yield line


def tail_of(path: Path, encoding: str) -> list[str]:
    """Return the last whole lines of a text file."""
    with open_regular(path) as file:
        size = file.seek(0, os.SEEK_END)
        start = max(0, size - TAIL)
        file.seek(start - start % 2)  # a letter of UTF-16 has two bytes
        text = file.read().decode(encoding.replace("-sig", ""), errors="replace")
    return [line for line in text.splitlines()[1 if start else 0 :] if line.strip()]


def split(line: str, delimiter: str, quoted: bool = False) -> list[str]:
    """Return the fields of a line, without blanks around them. delimiter " ": any run of blanks."""
    if quoted:
        return [word.strip() for word in next(csv.reader([line], delimiter=delimiter), [])]
    words = line.split() if delimiter == " " else line.strip("\r\n").split(delimiter)
    return [word.strip() for word in words]


def layout_of(path: Path, style: CsvStyle) -> Layout:
    """Return the layout of a text file. FormatError where it holds no numbers, or contradicts what
    is stated.
    """
    encoding = encoding_of(path)
    head: list[str] = []
    for line in lines_of(path, encoding):
        head.append(line)
        if len(head) >= HEADER_LINES + (style.skip or 0):
            break
    start, stated = style.skip or 0, style
    if head and re.fullmatch(r"\s*\"?sep=(.)\"?\s*", head[0].rstrip("\r\n"), re.I):
        told = re.fullmatch(r"\s*\"?sep=(.)\"?\s*", head[0].rstrip("\r\n"), re.I)
        sign = told.group(1) if told else ""
        if style.delimiter and style.delimiter != sign:
            raise FormatError(
                f"{path}: line 1 says {head[0].strip()!r}, the mapping's csv.delimiter says {style.delimiter!r}"
            )
        stated = replace(stated, delimiter=sign)
        start = max(start, 1)
    labview = _labview(head) if head and head[0].startswith(LABVIEW) else None
    if labview is not None:
        if style.skip is None:
            start = labview.first - 1
        stated = replace(
            stated,
            delimiter=stated.delimiter or labview.delimiter,
            decimal=stated.decimal or labview.decimal,
        )
    body = [
        (number, line)
        for number, line in enumerate(head[start:], start + 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not body:
        raise FormatError(f"{path} holds no numbers")
    found = _found(path, encoding, stated, body)
    if labview is None:
        return found
    return _with_labview(found, labview, style.skip is not None)


def _found(path: Path, encoding: str, style: CsvStyle, body: Sequence[tuple[int, str]]) -> Layout:
    """Return the layout of numbered lines that hold numbers, at least at their end."""
    tried: list[str] = []
    quoted = any('"' in line for _, line in body[-20:])
    for delimiter in [style.delimiter] if style.delimiter else DELIMITERS:
        sample = [split(line, delimiter, quoted and delimiter != " ") for _, line in body[-20:]]
        # The last line may be cut short; the reader looks at it again.
        sample = sample[:-1] if len(sample) > 2 else sample
        width = len(sample[-1])
        if any(len(row) != width for row in sample[len(sample) // 2 :]):
            tried.append(delimiter)
            continue
        if width > 1 and all(row[-1] == "" for row in sample if len(row) == width):
            width -= 1  # every line ends with the delimiter
        if width == 1 and not style.delimiter and delimiter != " ":
            continue
        decimals = [style.decimal] if style.decimal else [".", ","]
        fitting = [sign for sign in decimals if sign != delimiter and _reads(sample, width, sign)]
        if not fitting:
            tried.append(delimiter)
            continue
        if len(fitting) > 1 and _differ(sample, width):
            # One word such as 0,123 among all the lines decides: no thousands begin with 0.
            every = [split(line, delimiter, quoted and delimiter != " ") for _, line in body]
            fitting = [sign for sign in fitting if _reads(every, width, sign)] or fitting
        if len(fitting) > 1 and _differ(sample, width):
            word = next(w for row in sample for w in row if clean(w, ".") != clean(w, ","))
            raise FormatError(
                f"{path}: {word!r} may be thousands or a decimal: write `csv: {{decimal: ...}}` in the mapping"
            )
        return _with_header(path, encoding, delimiter, fitting[0], width, quoted, body)
    shown = body[-1]
    said = (
        f"with the delimiter {style.delimiter!r}" if style.delimiter else "with any delimiter"
    ) + (f" and the decimal sign {style.decimal!r}" if style.decimal else "")
    raise FormatError(
        f"{path} cannot be read as csv {said}: line {shown[0]} is {shown[1].strip()[:60]!r}; write "
        "`csv: {delimiter: ..., decimal: ..., skip: ...}` in the mapping"
    )


def _reads(sample: Sequence[Sequence[str]], width: int, decimal: str) -> bool:
    """Return whether some column holds numbers in most rows, and every column numbers, clock times,
    nothing, or words without a digit before.
    """
    good = 0
    for n in range(width):
        words = [row[n] for row in sample if len(row) >= width and row[n]]
        told = [word for word in words if clean(word, decimal) is not None]
        good += bool(told) and len(told) >= 0.8 * len(words)
        strange = [word for word in words if clean(word, decimal) is None and not is_clock(word)]
        if any(re.match(r"[-+]?[\d.,]+$", word) for word in strange):
            return False
    return good > 0


def _differ(sample: Sequence[Sequence[str]], width: int) -> bool:
    """Return whether some word of a sample is another number with the other decimal sign."""
    words = [word for row in sample for word in row[:width]]
    return any(
        (a := clean(word, ".")) is not None
        and (b := clean(word, ",")) is not None
        and float(a) != float(b)
        for word in words
    )


def _with_header(
    path: Path, encoding: str, delimiter: str, decimal: str, width: int, quoted: bool,
    body: Sequence[tuple[int, str]],
) -> Layout:  # fmt: skip
    """Return the layout with its header: the last line of words before the numbers, and a row of
    units below it.
    """
    rows = [split(line, delimiter, quoted and delimiter != " ") for _, line in body]
    numeric = [clean(word, decimal) is not None for word in rows[-min(len(rows), 2)][:width]]

    def is_data(row: Sequence[str]) -> bool:
        given = [
            clean(word, decimal) is not None or is_clock(word)
            for word, number in zip(row, numeric, strict=False)
            if number and word
        ]
        return bool(given) and all(given) and len(row) >= width

    begin = len(rows)
    while begin > 0 and is_data(rows[begin - 1]):
        begin -= 1
    if begin == len(rows):
        begin = next((n for n, row in enumerate(rows) if is_data(row)), len(rows))
    if begin >= len(rows):
        raise FormatError(f"{path} holds no numbers below its headers")
    heads = [
        row[:width]
        for row in rows[:begin]
        if any(row) and len(row) >= width - 1 and _is_words(row, decimal)
    ]
    several = [row for row in rows[:begin] if len([word for word in row if word]) > 1]
    if not heads and several and delimiter != " ":
        raise FormatError(
            f"{path} has {len(several[-1])} headers over {width} columns: is {delimiter!r} the decimal sign as well?"
        )
    units = [""] * width
    names = [str(n + 1) for n in range(width)]
    if heads:
        last = [*heads[-1], *[""] * (width - len(heads[-1]))]
        if _is_units(last):
            units = [word.strip("[]()<>{} ") for word in last]
            names = [*heads[-2], *[""] * (width - len(heads[-2]))] if len(heads) > 1 else last
        else:
            names = last
            units = [unit_in(word) for word in last]
    data = tuple(tuple(row[:width]) for row in rows[begin:])
    _refuse_doubled(path, delimiter, data, quoted)
    number = body[begin][0]
    return Layout(
        encoding, delimiter, decimal, number, tuple(names), tuple(units),
        f"the header above line {number}", width, quoted, data,
    )  # fmt: skip


def _is_words(row: Sequence[str], decimal: str) -> bool:
    """Return whether a row is no row of numbers."""
    return any(word and clean(word, decimal) is None for word in row)


def _is_units(row: Sequence[str]) -> bool:
    """Return whether a row holds units only, in brackets or bare."""
    words = [word for word in row if word]
    bracketed = all(re.fullmatch(r"[\[(<{].*[\])>}]", word) for word in words)
    return bool(words) and (bracketed or all(UNIT_WORD.fullmatch(word) for word in words))


def _refuse_doubled(
    path: Path, delimiter: str, rows: Sequence[Sequence[str]], quoted: bool
) -> None:
    """Raise FormatError where every other column holds the digits behind a decimal comma: unsigned,
    with zeros in front.
    """
    if delimiter != "," or quoted or not rows:
        return
    width = len(rows[0])
    for n in range(1, width):
        behind = [row[n] for row in rows if len(row) > n]
        before = [row[n - 1] for row in rows if len(row) > n]
        if (
            all(re.fullmatch(r"\d+", word) for word in behind)
            and any(re.fullmatch(r"0\d+", word) for word in behind)
            and all(re.fullmatch(r"[-+]?\d+", word) for word in before)
        ):
            raise FormatError(
                f"{path}: column {n + 1} holds digits behind a decimal comma ({before[-1]},{behind[-1]}): the comma is both "
                "delimiter and decimal sign here; export the file with another delimiter"
            )


@dataclass(frozen=True)
class _Labview:
    """What the head of a LabVIEW measurement file tells; by channel: units, x0 and step in s."""

    first: int
    delimiter: str
    decimal: str
    units: tuple[str, ...]
    starts: tuple[float, ...]
    steps: tuple[float, ...]
    x_columns: str
    unit_line: int


def _labview(head: Sequence[str]) -> _Labview:
    """Return what the two heads of a LabVIEW measurement file tell."""
    told: dict[str, list[str]] = {}
    ends, unit_line = [], 0
    for number, line in enumerate(head, 1):
        words = [word.strip() for word in line.rstrip("\r\n").split("\t")]
        if words[0] == END_OF_HEADER:
            ends.append(number)
        if len(ends) > 1:
            break
        if words[0] == "Y_Unit_Label":
            unit_line = number
        told[words[0]] = [word for word in words[1:] if word]
    decimal = (told.get("Decimal_Separator") or ["."])[0]
    separator = (told.get("Separator") or ["Tab"])[0]

    def values(key: str) -> tuple[float, ...]:
        cleaned = [clean(word, decimal) for word in told.get(key, [])]
        return tuple(float(word) for word in cleaned if word is not None)

    return _Labview(
        (ends[-1] if ends else 0) + 1,
        {"Tab": "\t", "Comma": ","}.get(separator, separator),
        decimal,
        tuple(told.get("Y_Unit_Label", [])),
        values("X0"),
        values("Delta_X"),
        (told.get("X_Columns") or ["One"])[0],
        unit_line,
    )


def _with_labview(found: Layout, labview: _Labview, skipped: bool) -> Layout:
    """Return the layout with what LabVIEW's head tells of its channels."""
    count = max(len(labview.units), len(labview.steps))
    each, offset = (2, 1) if labview.x_columns == "Multi" else (1, 1)
    places = {offset + each * n: n for n in range(count)}

    def spread(values: Sequence[str]) -> tuple[str, ...]:
        return tuple(
            values[places[n]] if n in places and places[n] < len(values) else ""
            for n in range(found.width)
        )

    def spread_numbers(values: Sequence[float]) -> tuple[float, ...]:
        return tuple(
            values[places[n]] if n in places and places[n] < len(values) else float("nan")
            for n in range(found.width)
        )

    units = spread(labview.units)
    return replace(
        found,
        units=found.units if skipped else units,
        units_at=found.units_at if skipped else f"line {labview.unit_line}, Y_Unit_Label",
        skipped=units if skipped else (),
        starts=() if skipped else spread_numbers(labview.starts),
        steps=() if skipped else spread_numbers(labview.steps),
    )
