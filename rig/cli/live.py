"""The live view of a running campaign: a bar with time left, and a table that fills as runs are analysed."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass

from rich.console import Console, Group
from rich.live import Live
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from rig.campaign import Campaign
from rig.campaign import Progress as Step
from rig.cli.tables import number, scaled

LINES = 12
"""Conditions shown at a time: those that changed last."""


@dataclass(frozen=True)
class Line:
    """What the view says of a condition (SI), and how many runs it has."""

    bed: str
    fill: float | None
    diameter: float | None
    acceleration: float
    runs: int


def lines_of(campaign: Campaign) -> dict[str, Line]:
    """The conditions of a campaign."""
    repeats = campaign.protocol.repeats.n
    return {
        c.id: Line(c.scene.bed, c.scene.grains.fill, c.scene.grains.diameter, c.drive.acceleration, repeats)
        for c in campaign.conditions
    }


class LiveView:
    """Takes a campaign's progress; draws on a terminal, elsewhere says one line for every tenth of the runs."""

    def __init__(self, lines: Mapping[str, Line], console: Console) -> None:
        self._console = console
        self._sums: dict[str, list[float]] = {}
        self._flags: dict[str, set[str]] = {}
        self._lines = lines
        self._bar = Progress(
            TextColumn("runs"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("left"),
            TimeRemainingColumn(), console=console,
        )  # fmt: skip
        self._task = self._bar.add_task("runs", total=sum(line.runs for line in lines.values()))

    def step(self, step: Step) -> None:
        """A run is done."""
        found = self._sums.pop(step.condition, [])
        self._sums[step.condition] = found if step.energy is None else [*found, step.energy.energy.W]
        flags = ("unusable",) if step.energy is None else step.energy.flags
        self._flags.setdefault(step.condition, set()).update(flags)
        self._bar.update(self._task, completed=step.done)
        if not self._console.is_terminal and (10 * step.done) // step.total != (10 * (step.done - 1)) // step.total:
            self._console.print(f"{step.done} of {step.total} runs")

    def __rich__(self) -> Group:
        table = Table(box=None, pad_edge=False)
        for name in ("condition", "bed", "fill", "d", "a", "runs", "W_exp", "flags"):
            table.add_column(name, justify="left" if name in ("condition", "bed", "flags") else "right")
        for key in list(self._sums)[-LINES:]:
            line, found = self._lines[key], self._sums[key]
            table.add_row(
                key, line.bed, f"{scaled(line.fill, 100)} %", f"{scaled(line.diameter, 1e3)} mm",
                f"{line.acceleration:g} m/s2", f"{len(found)}/{line.runs}",
                f"{number(sum(found) / len(found))} J" if found else "-",
                " ".join(sorted(self._flags[key])),
            )  # fmt: skip
        return Group(self._bar, table)


@contextmanager
def live_view(lines: Mapping[str, Line], console: Console) -> Iterator[LiveView]:
    """A view that is drawn while the block runs."""
    view = LiveView(lines, console)
    if console.is_terminal:
        with Live(view, console=console, refresh_per_second=4, transient=True):
            yield view
    else:
        yield view
