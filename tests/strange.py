"""Text that strangers may write, and what an output is made of whatever they wrote."""

import csv
import io
import json
import re
import xml.etree.ElementTree as ET
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

from hypothesis import strategies as st
from markdown_it import MarkdownIt

from daq.strange_text import HIDDEN

FRAGMENTS = (
    "\x1b[2J",
    "\x1b]0;t\x07",
    "\x9b31m",
    "\x08\x08",
    "\x7f",
    "\x00",
    "\r",
    "\n",
    "\t",
    "\u202e",
    "\u2066",
    "\u200b",
    "\u2028",
    "\ufeff",
    "\u00ad",
    "\ufffe",
    "\U000e0041",
    "\u3164",
    "[red]",
    "[/]",
    "[link=x]",
    ":smile:",
    "|",
    "\n# x",
    "\n- x",
    "<script>",
    "</svg>",
    "]]>",
    "<!--",
    "&#8238;",
    "&lt;",
    "'",
    '"',
    "`",
    "**",
    "~~",
    "![x](y)",
    "$\\frac$",
    "%s",
    "{0}",
    "{content:x}",
    "verdict: passes",
    "ä",
    "力",
    "1. x",
    "- x",
    "1) x",
    "===",
    "---",
    "_x_",
    "__x__",
    "$x$",
    "http://x.de",
    "www.x.de",
    "a@x.de",
    "\\",
    "\\|",
    "[x]: y",
    "    x",
    ": --",
)
STARTS = (
    "",
    "=HYPERLINK(1)",
    "+1",
    "-1",
    "@x",
    "\t=1",
    "\r",
    " =1",
    "＝1",
    '"=1',
    "'@x",
    "x;=1",
    "1. x",
    "- x",
    "+ x",
)
hostile = st.builds(
    "".join, st.tuples(st.sampled_from(STARTS), *[st.sampled_from(FRAGMENTS)] * 3)
) | st.text(st.characters(exclude_categories=("Cs",)), min_size=1, max_size=8)

PRE = re.compile("<pre>.*?</pre>", re.DOTALL)
TEXT = ("text", "text_special")


class Page(HTMLParser):
    """Counts the elements of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: Counter[str] = Counter()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        self.tags[tag] += 1
        assert not any(
            name.startswith("on") or (name == "href" and value != "data:,") for name, value in attrs
        )


def clean(text: str) -> None:
    assert HIDDEN.search(text.replace("\n", "")) is None


def markdown_shape(text: str) -> Counter[str]:
    """What a text of Markdown is made of; nothing in it becomes a link by itself (GitHub's
    autolinks), or a formula.
    """
    assert re.search(r"(?i)\w:/|www\.|(?<!\\)[@$]", text) is None
    tokens = MarkdownIt("gfm-like", {"linkify": False}).parse(text)
    return Counter(
        part.type
        for token in tokens
        for part in (token, *(token.children or ()))
        if part.type not in TEXT
    )


def svg_shape(text: str) -> Counter[str]:
    """What a drawing is made of."""
    return Counter(element.tag for element in ET.fromstring(text).iter())


def shape_of(folder: Path) -> dict[str, Any]:
    """What every file of a folder is made of, whatever its words are; each must parse and hide
    nothing.
    """
    found: dict[str, Any] = {}
    for path in sorted(folder.rglob("*")):
        if path.suffix not in {".json", ".csv", ".md", ".html", ".svg", ".uff"}:
            continue
        text = path.read_bytes().decode()
        clean(PRE.sub(lambda found: found[0].replace("\t", ""), text))
        name = str(path.relative_to(folder))
        if path.suffix == ".json":
            json.loads(text)
        elif path.suffix == ".csv":
            rows = list(csv.reader(io.StringIO(text)))
            found[name] = [len(row) for row in rows[:9]]
            for cell in (cell for row in rows for cell in row):
                assert not re.search(r"""(^|;)[\s"']*[=+@＝＋－＠]""", cell.replace("'", "x"))
                assert not cell.startswith("-") or float(cell) <= 0
        elif path.suffix == ".html":
            found[name] = Page(text).tags
        elif path.suffix == ".svg":
            found[name] = svg_shape(text)
        elif path.suffix == ".md":
            found[name] = markdown_shape(text)
            for kind in (
                "html_inline",
                "html_block",
                "link_open",
                "code_inline",
                "fence",
                "s_open",
            ):
                assert kind not in found[name]
    return found


def swapped(value: Any, swap: dict[str, str], ids: list[str]) -> Any:
    """A JSON value with its strings replaced, and of its keys those that are ids."""
    if isinstance(value, dict):
        return {
            swap[key] if key in ids else key: swapped(part, swap, ids)
            for key, part in value.items()
        }
    if isinstance(value, list):
        return [swapped(part, swap, ids) for part in value]
    return swap.get(value, value) if isinstance(value, str) else value
