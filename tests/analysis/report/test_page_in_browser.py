"""The page in a browser: no network, no console error, figures seen, tables sorted, no sideways
scroll, a PDF.
"""

import json
import re
import shutil
import subprocess
from html import unescape
from pathlib import Path

import pytest
from page_report import demo_report

from analysis import write_report
from analysis.report.sections import plots

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(
        BROWSER is None,
        reason="No Chromium here: install `chromium` to test the page in a browser.",
    ),
]

PROBE = """
const seen = {width: innerWidth, wide: document.documentElement.scrollWidth, figures: 0, unseen: [], unsorted: [],
  cut: [], tables: 0, resources: performance.getEntriesByType("resource").map(entry => entry.name)};
for (const details of document.querySelectorAll("details")) details.open = true;
for (const svg of document.querySelectorAll("figure svg")) {
  const box = svg.getBoundingClientRect();
  seen.figures += 1;
  if (box.width < 100 || box.height < 20 || !svg.getAttribute("aria-label"))
    seen.unseen.push(svg.outerHTML.slice(0, 80));
  const bounds = svg.getBBox(), view = svg.viewBox.baseVal;
  if (bounds.x < -1 || bounds.y < -1 || bounds.x + bounds.width > view.width + 1
    || bounds.y + bounds.height > view.height + 1) seen.cut.push(svg.getAttribute("aria-label"));
}
for (const table of document.querySelectorAll("table")) {
  seen.tables += 1;
  const before = table.tBodies[0].rows.length;
  for (const button of table.querySelectorAll("th button")) for (const sign of [1, -1]) {
    button.click();
    const column = button.parentElement.cellIndex, cells = [...table.tBodies[0].rows].map(row => row.cells[column]);
    const found = cells.map(cell => Number((cell.dataset.v ?? "nan").replace("inf", "Infinity")));
    const values = found.filter(value => !isNaN(value));
    const sorted = values.every((value, i) => !i || (sign > 0 ? value >= values[i - 1] : value <= values[i - 1]));
    const said = button.parentElement.getAttribute("aria-sort") === (sign > 0 ? "ascending" : "descending");
    if (!sorted || !said || cells.length !== before) seen.unsorted.push(button.textContent);
  }
}
seen.wide = Math.max(seen.wide, document.documentElement.scrollWidth);
seen.scrolled = [...document.querySelectorAll(".wide")].filter(part => part.scrollWidth > part.clientWidth + 1).length;
parent.postMessage("PROBE" + JSON.stringify(seen), "*");
"""
FRAME = """<!doctype html><title>waits</title><script>
addEventListener("message", message => { document.title = message.data; });
</script><iframe src="probe.html" width="%d" height="900" style="border:0"></iframe>"""
"""A window is never narrower than 500 px; a frame may be."""


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    write_report(demo_report(), folder)
    return folder / "report.html"


def browse(page: Path, *options: str) -> subprocess.CompletedProcess[str]:
    assert BROWSER is not None
    return subprocess.run(
        [
            BROWSER,
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
            "--enable-logging=stderr",
            f"--user-data-dir={page.parent / 'profile'}",
            "--host-resolver-rules=MAP * ~NOTFOUND",
            *options,
            page.as_uri(),
        ],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )


@pytest.mark.parametrize("width", [1280, 390])
def test_the_page_works_without_a_network(page, width):
    probed, frame = page.with_name("probe.html"), page.with_name("frame.html")
    probed.write_text(
        page.read_text(encoding="utf-8").replace("</body>", f"<script>{PROBE}</script></body>"),
        "utf-8",
    )
    frame.write_text(FRAME % width, encoding="utf-8")
    done = browse(frame, "--window-size=1400,1000", "--virtual-time-budget=5000", "--dump-dom")
    assert [line for line in done.stderr.splitlines() if "CONSOLE" in line] == []
    title = re.search(r"<title>PROBE(.*?)</title>", done.stdout, re.DOTALL)
    assert title is not None, done.stderr
    seen = json.loads(unescape(title[1]))
    assert seen["width"] == width
    assert seen["wide"] <= width
    assert seen["resources"] == []
    assert seen["figures"] == sum(len(plot.panels) for plot in plots(demo_report()))
    assert (seen["unseen"], seen["cut"], seen["unsorted"]) == ([], [], [])
    assert seen["tables"] >= 6
    if width < 640:
        assert seen["scrolled"] == 0


def test_the_page_prints(page):
    paper = page.with_name("report.pdf")
    browse(page, "--no-pdf-header-footer", f"--print-to-pdf={paper}")
    data = paper.read_bytes()
    assert data.startswith(b"%PDF-")
    assert 3 <= len(re.findall(rb"/Type\s*/Page\b", data)) <= 40
