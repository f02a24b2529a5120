"""Write docs/performance.md from the rows of a run: the same rows give the same bytes."""

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from daq.whole_files import write_whole
from rig.benchmarks.results.figures import LADDER, PRECISION, SCALING, drawn
from rig.benchmarks.results.tables import ResultTable, number, tables

Row = dict[str, Any]

JSONL, PAGE, FIGURES = "bench.jsonl", "performance.md", "figures"

HEAD = """# Speed against error

Written by `rig bench --out docs`{quick}; the numbers are those of `{jsonl}` beside this page.
To measure your own machine: `rig bench --out DIR` (some minutes) or `rig bench --quick` (under
a minute on two free cores).

Measured {created} on {cpu}, {cores} cores, load {load} at the start; Python {python},
{packages}; commit {commit}.

Times are wall times, medians of the rounds, with the least and the largest in brackets. What is
compared is measured in turn, in one process, in every round; a short call is repeated for half
a millisecond and the shortest of seven such batches counts; the first calls, which compile, are
left out. Ratios are formed round by round, so that what slows both down falls out. On a machine
that others use, too, times scatter and long calls suffer most: look at the load."""

TEXTS = {
    "claims": """## What is claimed

A slider is one row of grains: a mass in a box that moves as a sine, with friction, clearance and
walls; a single mass is one with weight. All methods get the same ones from the same start; the error
is that of the energy per cycle in the steady state, against closed forms or (e > 0, lid) closed
flights with root finding of their own (`rig/benchmarks/problems/reference.py`). All have the
same right-hand side; fixed steps take its sines from a table, except in the short steps that
lead from an event back to the grid. Compiled methods follow up to 4096 cycles or 200,000 steps,
of which what they set up once is a small part, `solve_ivp` the settling and two more cycles;
times are per cycle, none stops early where a state recurs. The cost of a method at an error is
read from its curve, log time over log error; a coarse setting counts with the largest error of
all finer ones, because nobody can know where errors cancel. The ratio is that of the summed
times over all problems. At 1e-9 ten times RK4 was demanded while RK4 computed its sines anew in
every step; since it takes them from a table, four.""",
    "each": """The same, problem by problem. A friction block that only stops and starts again
(eta 0.7) is kind to first-order stepping: without impacts it is of second order there.""",
    "checks": "",
    "cost_1e-04": """## Work-precision

{precision}

The methods: `ours` from event to event; `RK4` compiled, fixed steps, events located by Newton's
method on the step itself, a shorter step from each back to the grid; `Euler` semi-implicit and
`Moreau` time stepping at the midpoint, compiled, fixed steps, events not located; scipy's
`solve_ivp` with terminal events, restarted at each, resting phases given for nothing, atol =
rtol/100, steps of at most 1 rad so that none jumps over an event. Impacts count only while the
mass closes on the wall: after a lift-off the gap grows like t^3 and round-off alone would fake
one.""",
    "work": "",
    "states": """The orbit beside its energy: position and velocity after the last cycle that
was followed, the larger error of the two in units of the waveform, against closed flights; the
coarsest setting whose W is right to 1e-6. A block on a floor has nothing that pulls it back:
its errors add up over the cycles.""",
    "layers": """## Which model to choose

{ladder}

`numerics` is the error against the same rows averaged over 4096 cycles, `against many rows`
against {reference}. The variant as printed costs nothing and is a different quantity (one slip per
layer at any level). The layers variant with 8 rows is the default; fewer rows are wrong by per
cents at low level, more are for spread and force peaks.

Two advantages are kept apart. The layers variant follows a row no longer than until its state
recurs; the steppers, and `from event to event, 128 cycles throughout`, follow every row through
64 cycles of settling and 64 that count. The last column compares like with like: cycle for
cycle{same}; and, with RK4 stopped by the same rule, row for row{steady}.""",
    "small_beds": """A small bed, five layers of three rows, by scipy's `solve_ivp` row by row:
8 cycles from rest, the last four counted, against closed flights with root finding of their
own. What the bed sets up once (thresholds, its grid for the force) is most of its time here.""",
    "fill": """## The main job

10 cycles of settling and 40 that are recorded, in 160 runs: 400 s of rig time, kept for this
comparison whatever the shipped protocol settles. `whole process` is all of `rig run`: start of
Python, imports, run on all cores, report, figures. `recording` leaves out start, report and
figures; predictions, stand, acquisition, file and analysis of every run are in it. The lines
`of it` time other processes: what the start costs, and what the same imports would cost one
after the other (`rig run` makes a third of them while its workers are at it). Compiled modules
and kernels are there already, as after `make demo`.""",
    "parts": """## Parts

Errors: chain, the rebound against exact fractions; acquisition, a tone beside one that would
alias onto it; recorder, objects and attributes in which its file differs from the one that
plain h5py writes; reading, the energy through the gauge against the ledger (sensors err, and
the plain script compensates nothing). `plain h5py: the same file` makes the session's groups,
data sets, attributes and tables by h5py's own calls and flushes every block and row as the
recorder does; two filters of scipy stand beside the front end, its best single stage and the
same two stages as ours, neither with noise, codes and flags; `codes alone` has neither
attributes nor tables nor single-writer mode.""",
    "exponents": """## How cost grows

{scaling}

Grains only set the number of layers: from 1e5 to 1e10 of them these grow as the cube root.""",
    "compiling": """## Compiling

Kernels are compiled once for each installation and kept. `first` is with an empty cache,
`later` with a full one, each in a new process: of a method its first call, of `rig run`
everything. Until it has paid: cycles of a slider or single mass (the mean of those above, W to 1e-6)
after which the compiling and the cycles together took less than the best `solve_ivp`, which
compiles nothing.""",
    "drift": "## Long runs",
    "memory": """Peak resident memory of each process. The interpreter has imported the modules
that `rig run` ends with and done nothing else: what is above it is the run's.""",
    "failures": "## What failed",
}


def write_page(rows: Sequence[Row], folder: Path) -> Path:
    """Write the page and return its path; figures are expected in `figures` beside it.

    Raises OSError.
    """
    path = folder / PAGE
    write_whole(path, page(rows))
    return path


def page(rows: Sequence[Row]) -> str:
    """Return the page as text. Raises ValueError for rows without a machine."""
    machine = next((row for row in rows if row["kind"] == "machine"), None)
    if machine is None:
        raise ValueError("the rows do not begin with a machine")
    layers = next((row for row in rows if row["kind"] == "layers"), None)
    images = {f.name: f"![{f.alt}]({FIGURES}/{f.name}.svg)" for f in drawn(rows)}
    words = {
        **{which.name: images.get(which.name, "") for which in (PRECISION, LADDER, SCALING)},
        "reference": layers["reference"] if layers else "",
        **_ladder_words(rows),
    }
    parts = [_head(machine)]
    for table in tables(rows):
        text = TEXTS.get(table.name, "").format(**words)
        parts += [text] if text else []
        parts.append(markdown(table))
    return "\n\n".join(parts) + "\n"


def _ladder_words(rows: Sequence[Row]) -> dict[str, str]:
    """Return sentences with the times of the steppers relative to ours under the same rule for the
    cycles; "" without any.
    """
    sentences: dict[str, list[str]] = {"same": [], "steady": []}
    compared = [row for row in rows if row["kind"] == "layers" and row.get("times")]
    for method in dict.fromkeys(row["method"] for row in compared):
        each = [row["times"]["median"] for row in compared if row["method"] == method]
        name, _, rest = method.partition(" steps")
        kind = "steady" if rest.endswith("recurs") else "same"
        sentences[kind].append(
            f"{name} steps {number(min(each), 2)} to {number(max(each), 2)} times as long"
        )
    return {kind: ": " * bool(words) + "; ".join(words) for kind, words in sentences.items()}


def _head(machine: Row) -> str:
    packages = ", ".join(f"{name} {version}" for name, version in machine["packages"].items())
    return HEAD.format(
        quick=" with `--quick`" if machine["quick"] else "",
        jsonl=JSONL,
        created=machine["created"],
        cpu=machine["cpu"],
        cores=machine["cores"],
        load=machine["load"],
        python=machine["python"],
        packages=packages,
        commit=machine["git_commit"][:12] or "unknown",
    )


def markdown(table: ResultTable) -> str:
    """Return a table in Markdown, its title in bold above it."""
    rule = "|".join(" --- " if column in table.left else " ---: " for column in table.columns)
    lines = [f"**{table.title}**", "", _line(table.columns), f"|{rule}|", *map(_line, table.lines)]
    return "\n".join(lines)


def _line(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def read_rows(path: Path) -> list[Row]:
    """Return the rows of a bench.jsonl, also of an interrupted one. Raises OSError, ValueError."""
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines() if line]


def as_line(row: Row) -> str:
    """Return a row as a line of JSON."""
    return json.dumps(row, allow_nan=False)
