"""The code blocks of the project's pages, found by a Markdown parser of others."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from markdown_it import MarkdownIt

ROOT = Path(__file__).parents[2]
PAGES = tuple(path for path in (ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))))
SHELL, COMMANDS = ("bash", "console", "sh"), ("rig ", "make ", "python ", "#")
MARK = re.compile(r"<!--\s*(slow|exits [123]|not run: .+?)\s*-->")


@dataclass(frozen=True)
class Block:
    """One code block: its page and line, language ("" where it is indented), text, and the mark
    before it ("slow", "exits 1" to 3, "not run: why", or "")."""

    page: Path
    line: int
    language: str
    text: str
    mark: str

    @property
    def is_shell(self) -> bool:
        """Named so, or indented and made of commands."""
        lines = [line for line in self.text.splitlines() if line.strip()]
        return self.language in SHELL or (
            not self.language and all(line.startswith(COMMANDS) for line in lines)
        )

    @property
    def commands(self) -> list[str]:
        """The lines of a shell block, continued ones joined."""
        joined = self.text.replace("\\\n", " ")
        return [
            line
            for line in map(str.strip, joined.splitlines())
            if line and not line.startswith("#")
        ]


def blocks(page: Path) -> Iterator[Block]:
    """The blocks of a page in order."""
    mark = ""
    for token in MarkdownIt().parse(page.read_text(encoding="utf-8")):
        if token.type == "html_block":
            found = MARK.search(token.content)
            mark = found.group(1) if found else mark
        elif token.type in ("fence", "code_block"):
            line = (token.map or [0])[0] + 1
            yield Block(page, line, token.info.strip().partition(" ")[0], token.content, mark)
            mark = ""
        elif token.type.endswith("_open"):
            mark = ""
