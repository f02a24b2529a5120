"""The report in four forms, all from the same dict: JSON, CSV, Markdown and one self-contained HTML page."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from analysis.figures import Plot

__all__ = ["write_report"]


def write_report(report: dict[str, Any], out_dir: Path | str, figures: bool = True) -> tuple[Path, ...]:
    """Write report.json, report.csv, report.md and report.html into out_dir (made where missing); returns the paths.

    figures: draw them too (inside the page, and as SVG files under figures/). Equal reports give equal bytes: no date,
    path or machine is in them.
    """
    from analysis.report.csv import csv_text
    from analysis.report.html import html_text
    from analysis.report.markdown import markdown_text

    drawn: tuple[Plot, ...] = ()
    if figures:
        from analysis.figures import plots

        drawn = plots(report)
    texts = {
        "report.json": json.dumps(report, indent=1, ensure_ascii=False, allow_nan=False) + "\n",
        "report.csv": csv_text(report),
        "report.md": markdown_text(report, drawn),
        "report.html": html_text(report, drawn),
        **{f"figures/{plot.name}.svg": plot.svg for plot in drawn},
    }
    folder = Path(out_dir)
    written = []
    for name, text in texts.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")
        written.append(path)
    return tuple(written)
