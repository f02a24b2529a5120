"""Style sheet of the page, and the script that sorts its tables."""

__all__ = ["CSS", "SORT"]

CSS = """
:root { color-scheme: light; --ink: #1c1f23; --soft: #58606a; --line: #d9dde2; --paper: #fff; }
* { box-sizing: border-box; }
body { margin: 0; color: var(--ink); background: var(--paper); font: 16px/1.5 system-ui, sans-serif; }
main { max-width: 80rem; margin: 0 auto; padding: 1rem 1.25rem 3rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: .5rem 0; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; margin: 2rem 0 .4rem; }
p, ul { max-width: 46rem; margin: .5rem 0; }
ul { padding-left: 1.2rem; }
.lead { font-size: 1.1rem; }
.note { color: var(--soft); font-size: .875rem; }
.verdict { border: 1px solid var(--line); border-left: 6px solid; padding: .25rem 1rem .5rem; margin: 1.25rem 0;
  max-width: 48rem; }
.verdict.good { border-left-color: #0072b2; }
.verdict.bad { border-left-color: #b3261e; }
.verdict h2 { margin-top: .6rem; }
.result { font-size: 1.05rem; font-weight: 600; }
.wide { max-width: 100%; overflow-x: auto; }
figure { margin: 0; }
.panels { display: flex; flex-wrap: wrap; gap: .75rem; }
.panels svg { display: block; max-width: 100%; height: auto; }
h3 { font-size: 1rem; margin: 1.4rem 0 .3rem; }
.switch > summary { display: inline-block; list-style: none; border: 1px solid var(--soft); border-radius: .4rem;
  padding: .3rem .8rem; background: #f1f3f5; }
.switch > summary::-webkit-details-marker { display: none; }
.switch > summary::before { content: "Show: "; }
.switch[open] > summary::before { content: "Hide: "; }
.switch > summary:focus-visible { outline: 2px solid #0072b2; outline-offset: 2px; }
summary { cursor: pointer; font-weight: 600; margin: .8rem 0; }
pre { font-size: .75rem; white-space: pre-wrap; overflow-wrap: anywhere; background: #f6f7f8; padding: .75rem; }
table { border-collapse: collapse; font-size: .8125rem; font-variant-numeric: tabular-nums; }
th, td { padding: .25rem .5rem; border-bottom: 1px solid var(--line); text-align: left; vertical-align: top; }
th { border-bottom-color: var(--soft); vertical-align: bottom; }
td { white-space: nowrap; }
td.t { min-width: 16rem; max-width: 32rem; white-space: normal; overflow-wrap: break-word; }
td.n { text-align: right; }
tbody tr:hover { background: #f4f6f8; }
th button { all: unset; cursor: pointer; font-weight: 600; }
th button:focus-visible, .wide:focus-visible { outline: 2px solid #0072b2; outline-offset: 1px; }
th[aria-sort=ascending] button::after { content: " \\25B2"; }
th[aria-sort=descending] button::after { content: " \\25BC"; }
code { background: #f1f3f5; padding: .1rem .35rem; overflow-wrap: anywhere; }
@media screen and (max-width: 40rem) {
  main { padding: .5rem .8rem 2rem; }
  table, tbody { display: block; }
  thead tr { display: flex; flex-wrap: wrap; gap: .1rem .9rem; border-bottom: 1px solid var(--soft); }
  thead tr::before { content: "Sort by:"; color: var(--soft); }
  th { display: block; border: 0; padding: .1rem 0; }
  tbody tr { display: grid; grid-template-columns: 1fr 1fr; gap: 0 .7rem; padding: .4rem 0;
    border-bottom: 1px solid var(--line); }
  td, td.n, td.t { display: block; border: 0; padding: 0; text-align: left; white-space: normal; min-width: 0;
    max-width: none; overflow-wrap: anywhere; }
  td:not(.t) { display: flex; justify-content: space-between; align-items: baseline; gap: .25rem; }
  td.n { letter-spacing: -.01em; }
  td.t, td.w { grid-column: 1 / -1; }
  td:first-child { font-weight: 600; }
  td:empty { display: none; }
  td::before { color: var(--soft); font-size: .6875rem; font-weight: 400; flex: none; max-width: 60%; }
  td.t::before { display: block; }
}
@media print {
  body { font-size: 10pt; } main { max-width: none; padding: 0; } .wide { overflow: visible; }
  .panels svg { width: 8.3cm; } table { font-size: 7.5pt; } details { display: none; }
  th, td { white-space: normal; padding: 1pt 3pt; }
  section { break-inside: auto; } tr, svg, .verdict { break-inside: avoid; } h2, h3 { break-after: avoid; }
  thead { display: table-header-group; }
}
"""

SORT = """
for (const button of document.querySelectorAll("th button")) button.addEventListener("click", () => {
  const th = button.parentElement, body = th.closest("table").tBodies[0], column = th.cellIndex;
  const down = th.getAttribute("aria-sort") === "ascending";
  for (const other of th.parentElement.cells) other.removeAttribute("aria-sort");
  th.setAttribute("aria-sort", down ? "descending" : "ascending");
  const rows = [...body.rows].map(row => {
    const cell = row.cells[column], value = cell.dataset.v ? Number(cell.dataset.v.replace("inf", "Infinity")) : NaN;
    return { row, text: cell.textContent, value };
  });
  rows.sort((a, b) => {
    const blank = isNaN(a.value) - isNaN(b.value);
    if (blank) return blank;
    const words = isNaN(a.value), same = a.value === b.value;
    const order = words ? a.text.localeCompare(b.text, "en", { numeric: true }) : same ? 0 : a.value - b.value;
    return down ? -order : order;
  });
  body.append(...rows.map(entry => entry.row));
});
"""
