"""The English of docstrings: functions begin with a verb, and phrases that readers had to read twice
do not come back.
"""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("analysis", "daq", "rig")

TITLES = ("rig/benchmarks/hard", "rig/cli/app.py")
"""Docstrings that are titles of cases, and help texts of commands."""

NOT_YET = ("daq/documents", "rig/documents", "rig/importing", "rig/protocol")
"""Folders whose docstrings have not been read by this rule; remove each one that has."""

NO_VERB = {
    "A", "All", "An", "And", "Any", "As", "At", "By", "Each", "Every", "Everything", "For",
    "From", "Half", "How", "If", "In", "Is", "It", "Its", "Largest", "Least", "Mean", "Most",
    "Never", "No", "Number", "Of", "On", "One", "Same", "Shape", "So", "Some", "Standard", "The",
    "This", "To", "Value", "Values", "What", "When", "Whether", "Where", "Which", "Who", "Why",
    "With",
}  # fmt: skip
"""First words that occurred in place of a verb."""

RIDDLES = {
    r"\btold (apart )?from\b": "distinguished from",
    r"\bshares? of\b": "fraction of",
    r"\bso many\b": "name the number",
    r"\bleaves?\b.{0,30}\bopen\b": "say what is uncertain, and by how much",
    r"\bstands? in for\b": "replaces",
    r"\bgone on with\b": "resumed",
    r"\bmakes? of (it|them|him)\b": "name the result",
}
"""Phrases that engineers read twice, and the mend of each."""


def docstrings(package: str) -> Iterator[tuple[str, ast.AST, str]]:
    """Yield place, node and docstring of every module, class and function of a package."""
    for path in sorted((ROOT / package).rglob("*.py")):
        name = path.relative_to(ROOT).as_posix()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                text = ast.get_docstring(node)
                if text:
                    yield f"{name}:{getattr(node, 'lineno', 1)}", node, text


def is_property(node: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """Return whether a function is read as an attribute, whose docstring is a noun."""
    return any("property" in ast.unparse(each) for each in node.decorator_list)


@pytest.mark.parametrize("package", PACKAGES)
def test_docstrings_of_functions_begin_with_a_verb(package: str) -> None:
    """A word that begins with a lower-case letter, a symbol or a quotation mark is none either."""
    wrong = [
        f"{place}: {text.splitlines()[0]}"
        for place, node, text in docstrings(package)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and not is_property(node)
        if not place.startswith((*TITLES, *NOT_YET))
        if text.split()[0] in NO_VERB or not re.match(r"[A-Z][a-z]+\b", text)
    ]
    assert wrong == []


def test_phrases_that_are_read_twice_are_gone_from_the_analysis() -> None:
    wrong = [
        f"{place}: {found[0]!r}, better: {mend}"
        for place, _, text in docstrings("analysis")
        for riddle, mend in RIDDLES.items()
        for found in re.finditer(riddle, " ".join(text.split()))
    ]
    assert wrong == []
