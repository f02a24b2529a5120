"""Programs that stand in strings: no linter, no type checker and no renaming tool reads them."""

import ast
import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
OURS = ("rig", "daq", "analysis")


def programs() -> list[tuple[str, str]]:
    """Return place and text of every string with a line that imports one of the packages."""
    found = []
    for folder in (*OURS, "tests", "examples"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            tree = ast.parse(path.read_text(encoding="utf-8"))
            prose = {
                id(node.body[0].value)
                for node in ast.walk(tree)
                if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
                and node.body
                and isinstance(node.body[0], ast.Expr)
            }
            prose |= {
                id(part)
                for node in ast.walk(tree)
                if isinstance(node, ast.JoinedStr)
                for part in node.values
            }
            for node in ast.walk(tree):
                if isinstance(node, ast.Constant) and isinstance(node.value, str):
                    imports = re.search(
                        rf"(^|; )(from|import) ({'|'.join(OURS)})\b.* ", node.value, re.M
                    )
                    if imports and id(node) not in prose and "{" not in node.value:
                        found.append((f"{path.relative_to(ROOT)}:{node.lineno}", node.value))
    return found


PROGRAMS = programs()


def test_there_are_some() -> None:
    assert len(PROGRAMS) > 5


@pytest.mark.parametrize(("place", "text"), PROGRAMS, ids=[place for place, _ in PROGRAMS])
def test_it_is_a_program_whose_imports_are_there(place: str, text: str) -> None:
    try:
        tree = ast.parse(text)
    except SyntaxError as error:
        pytest.fail(f"{place}: {error}")
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] in OURS:
            module = importlib.import_module(node.module)
            for name in node.names:
                assert hasattr(module, name.name) or importlib.import_module(
                    f"{node.module}.{name.name}"
                )
