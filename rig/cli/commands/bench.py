"""`rig bench`: speed against error, as rows, tables, figures and a page."""

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any, TextIO

from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from daq.whole_files import fresh_file
from rig.benchmarks.results.figures import write_figures
from rig.benchmarks.results.page import FIGURES, JSONL, as_line, write_page
from rig.benchmarks.results.tables import tables
from rig.benchmarks.runner import Job, jobs, measured
from rig.cli.errors import INTERRUPTED
from rig.cli.terminal.output import say
from rig.cli.terminal.tables import table, terminal
from rig.errors import InputError, Mistake


def bench(quick: bool, out: Path | None, as_json: bool, todo: Sequence[Job] | None = None) -> int:
    """Measure, print and write; return the exit code 0, or 3 where interrupted: the rows measured
    so far are then in the file.
    """
    found: list[dict[str, Any]] = []
    work = jobs(quick) if todo is None else todo
    with _lines(out) as file:
        try:
            with _progress(work, as_json) as watch:
                for row in measured(work, quick, watch):
                    found.append(row)
                    if file is not None:
                        print(as_line(row), file=file, flush=True)
                    if as_json:
                        print(as_line(row), flush=True)
        except KeyboardInterrupt:
            kept = (
                "nothing was written" if out is None else f"{len(found)} rows are in {out / JSONL}"
            )
            say(f"rig: interrupted; {kept}", to_stderr=True)
            return INTERRUPTED
    if not as_json:
        console = terminal()
        for one in tables(found):
            console.print(table(one.title, one.columns, one.lines, one.left))
            console.print()
    if out is not None:
        written = [out / JSONL, write_page(found, out), *write_figures(found, out / FIGURES)]
        if not as_json:
            for path in written:
                terminal().print(str(path), highlight=False, soft_wrap=True)
    return 0


@contextmanager
def _lines(out: Path | None) -> Iterator[TextIO | None]:
    """Open the file of the rows before anything is measured; None without an output folder."""
    if out is None:
        with nullcontext():
            yield None
        return
    try:
        out.mkdir(parents=True, exist_ok=True)
        file = io.TextIOWrapper(fresh_file(out / JSONL), encoding="utf-8", write_through=True)
    except OSError as error:
        raise InputError(
            Mistake("--out", "", f"{out}, which cannot be written ({error})", "a folder")
        ) from None
    with file:
        yield file


@contextmanager
def _progress(work: Sequence[Job], quiet: bool) -> Iterator[Any]:
    """Show a bar with the time left on a terminal's standard error, elsewhere one line per job."""
    console = terminal(stderr=True, quiet=quiet)
    if not console.is_terminal:
        yield lambda job, done: None if done else console.print(job.title, highlight=False)
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("starting", total=sum(job.weight for job in work))

        def watch(job: Job, done: bool) -> None:
            bar.update(task, description=job.title, advance=job.weight if done else 0.0)

        yield watch
