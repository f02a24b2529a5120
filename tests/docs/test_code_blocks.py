"""Every code block of the pages does what it says: commands, programs, protocols."""

import contextlib
import io
import os
import re
import runpy
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from code_blocks import PAGES, ROOT, Block, blocks
from typer.testing import CliRunner

from rig.catalog.own_materials import read_materials
from rig.cli.app import app
from rig.cli.terminal import watch
from rig.importing.mapping import read_mapping
from rig.protocol.load import load_protocol

QUIET = ("text", "{toctree}", "{eval-rst}", "json")
LEAST = "schema: rig/protocol/1\nname: fragment\n"
PAGE_NAMES = {str(page.relative_to(ROOT)): page for page in PAGES}
EVERY = [block for page in PAGES for block in blocks(page)]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty folder with what a clone has; files are read in this process and not in a watched
    child.
    """
    for name in ("protocols", "examples", "tests"):
        (tmp_path / name).symlink_to(ROOT / name, target_is_directory=True)
    monkeypatch.setattr(watch, "go_on_watched", lambda *_: None)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run_shell(block: Block) -> None:
    for command in block.commands:
        words = shlex.split(command, comments=True)
        if words[0] == "make":
            targets = re.findall(
                r"^(\w+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE
            )
            assert words[1] in targets, command
        elif words[0] == "python":
            _program(words[1:])
        else:
            assert words[0] == "rig", command
            done = CliRunner().invoke(app, words[1:])
            wanted = (
                int(block.mark.removeprefix("exits ")) if block.mark.startswith("exits ") else 0
            )
            assert done.exit_code == wanted, f"{command}\n{done.output}\n{done.stderr}"


def _program(words: list[str]) -> None:
    """A program of the repository with its arguments."""
    before = sys.argv
    sys.argv = words
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            runpy.run_path(words[0], run_name="__main__")
    finally:
        sys.argv = before


def run_block(block: Block, names: dict[str, Any]) -> None:
    """Execute a block; `names` is what the page's Python blocks share."""
    place = f"{block.page.relative_to(ROOT)}:{block.line}"
    if block.is_shell:
        run_shell(block)
    elif block.language == "python":
        with contextlib.redirect_stdout(io.StringIO()):
            exec(compile(block.text, place, "exec"), names)
    elif block.language in ("yaml", ""):
        _yaml(block.text, place)
    else:
        assert block.language in QUIET, (
            f"{place}: a block in {block.language!r}; what cannot run is marked `text`"
        )


def _yaml(text: str, place: str) -> None:
    """A protocol, a mapping, a catalog of materials, or a part of a protocol."""
    assert ":" in text, f"{place}: neither commands nor YAML; what cannot run is marked `text`"
    if "schema: rig/map/" in text:
        Path("block.yaml").write_text(text, encoding="utf-8")
        read_mapping(Path("block.yaml"))
        return
    if "schema: rig/catalog/" in text:
        Path("materials.yaml").write_text(text, encoding="utf-8")
        assert read_materials(Path("materials.yaml"))
        return
    protocol = text if "schema:" in text else LEAST + text
    load_protocol(protocol if "\nname:" in protocol else f"{protocol}\nname: fragment\n")
    saved = re.match(r"# (\S+\.yaml)$", text.splitlines()[0])
    if saved:
        Path(saved.group(1)).write_text(text, encoding="utf-8")


def run_page(page: Path, slow: bool) -> None:
    names: dict[str, Any] = {}
    for block in blocks(page):
        if block.mark.startswith("not run") or (block.mark == "slow" and not slow):
            continue
        run_block(block, names)


@pytest.mark.parametrize("name", [name for name, page in PAGE_NAMES.items() if list(blocks(page))])
def test_the_blocks_of_a_page_run(name: str, folder: Path) -> None:
    assert os.getcwd() == str(folder)
    run_page(PAGE_NAMES[name], slow=False)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", sorted({str(b.page.relative_to(ROOT)) for b in EVERY if b.mark == "slow"})
)
def test_the_long_blocks_of_a_page_run_too(name: str, folder: Path) -> None:
    assert os.getcwd() == str(folder)
    run_page(PAGE_NAMES[name], slow=True)


@pytest.mark.parametrize("name", PAGE_NAMES)
def test_links_lead_somewhere(name: str) -> None:
    """Links to files of the repository; the site's builder looks at anchors and at the pages it
    builds only.
    """
    page = PAGE_NAMES[name]
    targets = re.findall(r"\]\(([^)#\s]+)", page.read_text(encoding="utf-8"))
    assert [t for t in targets if "://" not in t and not (page.parent / t).exists()] == []


def test_no_block_that_runs_is_held_to_the_wall_clock() -> None:
    """A busy machine would be late, and a test never times anything; replaying small sessions fast
    is no risk.
    """
    paced = [
        (block.page.name, command)
        for block in EVERY
        if block.is_shell and not block.mark.startswith("not run")
        for command in block.commands
        if command.startswith("rig run") and re.search(r"--speed(?! max)", command)
    ]
    assert paced == []


def test_few_blocks_cannot_run() -> None:
    """Each says why; beside them stand the blocks that are no code at all."""
    left_out = [block for block in EVERY if block.mark.startswith("not run")]
    assert len(left_out) <= len(EVERY) // 10
    assert len([block for block in EVERY if block.language not in QUIET]) > 20


def test_the_parser_sees_blocks_of_both_kinds() -> None:
    """The rules above hold for nothing at all as well."""
    assert any(block.language == "" and block.is_shell for block in EVERY)
    assert {"python", "yaml"} <= {block.language for block in EVERY}
