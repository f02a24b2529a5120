"""The report in four forms, all from the same values: JSON, CSV, Markdown and one self-contained
HTML page.
"""

import json
from pathlib import Path
from typing import TYPE_CHECKING

from analysis.shared_work import ForEach, both, here

if TYPE_CHECKING:
    from analysis.report.figures.drawing import Plot
    from analysis.results.report import Report

__all__ = ["read_report", "write_report"]

Files = dict[str, str | bytes]  # contents by name


def write_report(
    report: "Report",
    out_dir: Path | str,
    figures: bool = True,
    png: bool = False,
    each: ForEach = here,
) -> tuple[Path, ...]:
    """Write report.csv, report.md, report.html and report.json into out_dir (made where missing);
    return the paths.

    Every file is either complete or the old one; report.json is replaced last.

    figures: draw them too (inside the page, and as SVG files under figures/); png: as PNG files as
    well. each: makes the texts, here or in several processes. Equal reports give equal bytes: they
    contain no date, path or machine.
    """
    from analysis.report.csv import csv_text
    from analysis.report.html import html_text
    from analysis.report.markdown import markdown_text
    from analysis.report.sections import sections
    from daq.json_text import json_text
    from daq.whole_files import write_folder

    def document() -> Files:
        return {"report.json": json_text(report.document()) + "\n"}

    def to_read() -> Files:
        parts = sections(report, figures)
        plots = [plot for part in parts for plot in part.plots]
        return {
            "report.csv": csv_text(report),
            "report.md": markdown_text(report, parts),
            "report.html": html_text(report, parts),
            **{f"figures/{plot.name}.svg": plot.svg for plot in plots},
            **({f"figures/{plot.name}.png": _png(plot) for plot in plots} if png else {}),
        }

    first, last = both(each, to_read, document)
    return write_folder(Path(out_dir), first | last)


def read_report(path: Path | str) -> "Report":
    """Read a report.json back, or the one in a folder.

    OSError; AnalysisError where it is damaged, naming the place. Keys that this version does not
    know are ignored.
    """
    from analysis.results.report import Report
    from analysis.session.record import AnalysisError

    file = Path(path) / "report.json" if Path(path).is_dir() else Path(path)
    try:
        document = json.loads(file.read_bytes())
    except ValueError as error:
        raise AnalysisError(f"{file} is no JSON: {error}") from error
    if isinstance(document, dict) and document.get("schema") == "rig/agreement/1":
        why = "a report of the first edition; `rig report SESSION` writes it anew"
        raise AnalysisError(f"{file} is {why}")
    return Report.of(document, str(file))


def _png(plot: "Plot") -> bytes:
    from analysis.report.figures.drawing import arranged
    from analysis.report.figures.matplotlib_style import png

    return png(arranged(plot.panels, plot.across))
