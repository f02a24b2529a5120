r"""Text from strangers, made harmless: no character in it can steer a terminal, turn the order of letters or hide.

A session, a mapping, the header of a record or the name of a file may hold anything. Characters that a reader cannot
see are written as their escapes (`\x1b`, `\u202e`), so that he sees that they are there.
"""

import json
import re
from typing import Any, Literal

from daq.indented import indented

__all__ = ["HIDDEN", "LINES", "cell_text", "json_text", "visible"]

LINES = "\n\t"
"""What text of several lines may keep where it stands as it is."""

HIDDEN = re.compile(
    "[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufdd0-\ufdef\ufffe\uffff"
    "\u00ad\u034f\u061c\u115f\u1160\u17b4\u17b5\u180b-\u180f\u200b-\u200f\u202a-\u202e\u2060-\u206f\u3164"
    "\ufe00-\ufe0f\ufeff\uffa0\ufff0-\ufffb\U0001bca0-\U0001bca3\U0001d173-\U0001d17a\U000e0000-\U000e0fff"
    + "".join(f"{chr(plane + 0xFFFE)}{chr(plane + 0xFFFF)}" for plane in range(0x10000, 0x110000, 0x10000))
    + "]"
)
"""C0 and C1 controls with DEL; surrogates; noncharacters, which XML has no place for; separators of lines and
paragraphs; and Unicode's Default_Ignorable_Code_Point (DerivedCoreProperties.txt), bidirectional controls and
zero-width characters among them."""

_BUT_LINES = re.compile(rf"(?!\n){HIDDEN.pattern}")

_FORMULA = re.compile(r"""(^|;)(?=[\s"']*[=+\-@\t\r\n＝＋－＠])""")
"""Where a spreadsheet may begin a formula: at the start of a cell, spaces and quotes skipped, and after the semicolon
that half of the world separates cells by."""


def visible(text: str, keep: str = "") -> str:
    """Return text with its hidden characters as escapes, those of `keep` as they are."""
    return HIDDEN.sub(lambda found: found[0] if found[0] in keep else _escaped(found[0]), text)


def json_text(value: Any, indent: Literal[1] | None = 1) -> str:
    """Return JSON text whose hidden characters are JSON's own escapes: it reads back to the same value."""
    one_line = json.JSONEncoder(ensure_ascii=False, allow_nan=False).encode
    text = one_line(value) if indent is None else indented(value)
    if text.isascii() and "\x7f" not in text:  # JSON escapes the other controls by itself
        return text
    return _BUT_LINES.sub(lambda found: _json_escaped(found[0]), text)


def cell_text(value: Any) -> Any:
    """Return a cell of a CSV file: a number as it is, text that a spreadsheet would take for a formula behind an
    apostrophe."""
    if not isinstance(value, str):
        return value
    return visible(_FORMULA.sub(r"\1'", value))


def _escaped(character: str) -> str:
    code = ord(character)
    named = {"\n": "\\n", "\t": "\\t", "\r": "\\r"}.get(character)
    return named or (f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}")


def _json_escaped(character: str) -> str:
    return json.dumps(character)[1:-1] if character != "\x7f" else "\\u007f"
