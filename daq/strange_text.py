r"""Make text from strangers harmless: no character can steer a terminal, reverse the order of
letters or hide.

A session, a mapping, the header of a record or a file name may hold anything. Invisible characters
are written as escapes (`\x1b`, `\u202e`), so that the reader sees that they are there.
"""

import re
from typing import Any

__all__ = ["HIDDEN", "LINES", "cell_text", "visible"]

LINES = "\n\t"
"""Control characters that text of several lines may keep."""

HIDDEN = re.compile(
    "[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufdd0-\ufdef\ufffe\uffff"
    "\u00ad\u034f\u061c\u115f\u1160\u17b4\u17b5\u180b-\u180f\u200b-\u200f\u202a-\u202e\u2060-\u206f\u3164"
    "\ufe00-\ufe0f\ufeff\uffa0\ufff0-\ufffb\U0001bca0-\U0001bca3\U0001d173-\U0001d17a\U000e0000-\U000e0fff"
    + "".join(
        f"{chr(plane + 0xFFFE)}{chr(plane + 0xFFFF)}" for plane in range(0x10000, 0x110000, 0x10000)
    )
    + "]"
)
"""Invisible characters: C0 and C1 controls with DEL; surrogates; noncharacters, which XML does not
allow; line and paragraph separators; and Unicode's Default_Ignorable_Code_Point
(DerivedCoreProperties.txt), which includes bidirectional controls and zero-width characters.
"""

_FORMULA = re.compile(r"""(^|;)(?=[\s"']*[=+\-@\t\r\n＝＋－＠])""")
"""Places where a spreadsheet may begin a formula: the start of a cell, after spaces and quotes, and
after a semicolon, which is the cell separator in half of the world.
"""


def visible(text: str, keep: str = "") -> str:
    """Return text with its hidden characters escaped, except those in `keep`."""
    return HIDDEN.sub(lambda found: found[0] if found[0] in keep else _escaped(found[0]), text)


def cell_text(value: Any) -> Any:
    """Return a cell of a CSV file: a number unchanged; text with an apostrophe before anything that
    a spreadsheet would take for a formula.
    """
    if not isinstance(value, str):
        return value
    return visible(_FORMULA.sub(r"\1'", value))


def _escaped(character: str) -> str:
    code = ord(character)
    named = {"\n": "\\n", "\t": "\\t", "\r": "\\r"}.get(character)
    if named:
        return named
    if code < 0x100:
        return f"\\x{code:02x}"
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"
