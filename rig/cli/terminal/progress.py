"""Progress of work that is counted: a bar with the time left on a terminal, elsewhere a line for every tenth."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from rig.cli.terminal.tables import terminal

Watch = Callable[[int, int], None]
"""Called with how many are done, of how many."""


@contextmanager
def progress(what: str, quiet: bool = False) -> Iterator[Watch]:
    """What to call whenever one more is done; drawn on standard error."""
    console = terminal(stderr=True, quiet=quiet)
    if not console.is_terminal:

        def line(done: int, of: int) -> None:
            if (10 * done) // of != (10 * (done - 1)) // of:
                console.print(f"{done} of {of} {what}")

        yield line
        return
    columns = (
        TextColumn(what), BarColumn(bar_width=30), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("left"),
        TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, of: bar.update(task, completed=done, total=of)
