"""The report in four forms, all from the same dict: JSON, CSV, Markdown and one self-contained HTML page."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from analysis.report.drawing import Plot

__all__ = ["write_report"]


def write_report(
    report: dict[str, Any], out_dir: Path | str, figures: bool = True, png: bool = False
) -> tuple[Path, ...]:
    """Write report.json, report.csv, report.md and report.html into out_dir (made where missing); returns the paths.

    figures: draw them too (inside the page, and as SVG files under figures/); png: as PNG files as well. Equal reports
    give equal bytes: no date, path or machine is in them.
    """
    from analysis.report.csv import csv_text
    from analysis.report.html import html_text
    from analysis.report.markdown import markdown_text
    from analysis.report.sections import sections

    parts = sections(report, figures)
    texts = {
        "report.json": json.dumps(report, indent=1, ensure_ascii=False, allow_nan=False) + "\n",
        "report.csv": csv_text(report),
        "report.md": markdown_text(report, parts),
        "report.html": html_text(report, parts),
        **{f"figures/{plot.name}.svg": plot.svg for part in parts for plot in part.plots},
    }
    folder = Path(out_dir)
    written = []
    for name, text in texts.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")
        written.append(path)
    for plot in (plot for part in parts for plot in part.plots if png):
        written.append(folder / "figures" / f"{plot.name}.png")
        written[-1].write_bytes(_png(plot))
    return tuple(written)


def _png(plot: "Plot") -> bytes:
    from analysis.figures import png
    from analysis.report.drawing import arranged

    return png(arranged(plot.panels, plot.across))
