"""The documentation site: `make docs` builds it into build/docs, every warning an error."""

import re
from typing import Any

project = "Particle-damper virtual test rig"
author = "The authors of particle-damper-rig"
extensions = ["myst_parser", "sphinx.ext.autodoc"]
html_theme = "furo"
html_title = "Particle-damper rig"
html_show_copyright = False
html_show_sphinx = False
exclude_patterns = ["conf.py"]
myst_heading_anchors = 3
nitpicky = True
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
nitpick_ignore_regex = [("py:.*", ".*")]  # types of other libraries have no page here


def as_paragraphs(
    _app: Any, _what: str, _name: str, _obj: Any, _options: Any, lines: list[str]
) -> None:
    """Make a paragraph of each entry "name : meaning" of a docstring, with its indented lines."""
    found: list[str] = []
    for line in lines:
        entry = re.match(r"([A-Za-z_][\w, ]*) : (.+)", line)
        if entry:
            found += ["", f"**{entry[1]}**: {entry[2]}"]
        else:
            found.append(line.lstrip() if line.startswith("    ") else line)
    lines[:] = found


def setup(app: Any) -> None:
    """Connect to the builder."""
    app.connect("autodoc-process-docstring", as_paragraphs)
