"""Progress of counted work: a bar with the time left on a terminal, elsewhere one line for every
tenth.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from rig.cli.terminal.tables import terminal

Watch = Callable[[int, int], None]
"""Called with (number done, total)."""


@contextmanager
def progress(what: str, quiet: bool = False) -> Iterator[Watch]:
    """Yield a function to call after each unit of work; progress is drawn on standard error."""
    console = terminal(stderr=True, quiet=quiet)
    if not console.is_terminal:

        def line(done: int, of: int) -> None:
            if (10 * done) // of != (10 * (done - 1)) // of:
                console.print(f"{done} of {of} {what}")

        yield line
        return
    columns = (
        TextColumn(what),
        BarColumn(bar_width=30),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, of: bar.update(task, completed=done, total=of)
