"""The live view of a running campaign: a bar with time left, and a table that fills as runs are analysed."""

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console, Group
from rich.live import Live
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from rig.campaign import Campaign
from rig.campaign import Progress as Step
from rig.cli.tables import number

LINES = 12
"""Conditions shown at a time: those that changed last."""


class LiveView:
    """Takes the campaign's progress; draws on a terminal, elsewhere says one line for every tenth of the runs."""

    def __init__(self, campaign: Campaign, console: Console) -> None:
        self._console = console
        self._sums: dict[str, list[float]] = {}
        self._flags: dict[str, set[str]] = {}
        self._conditions = {c.id: c for c in campaign.conditions}
        self._repeats = campaign.protocol.repeats.n
        self._bar = Progress(
            TextColumn("runs"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("left"),
            TimeRemainingColumn(), console=console,
        )  # fmt: skip
        self._task = self._bar.add_task("runs", total=len(campaign.runs))

    def step(self, step: Step) -> None:
        """A run is done."""
        self._sums.setdefault(step.run.condition.id, []).append(step.energy.energy.W)
        self._sums[step.run.condition.id] = self._sums.pop(step.run.condition.id)
        self._flags.setdefault(step.run.condition.id, set()).update(step.energy.flags)
        self._bar.update(self._task, completed=step.done)
        if not self._console.is_terminal and (10 * step.done) // step.total != (10 * (step.done - 1)) // step.total:
            self._console.print(f"{step.done} of {step.total} runs")

    def __rich__(self) -> Group:
        table = Table(box=None, pad_edge=False)
        for name in ("condition", "bed", "fill", "d", "a", "runs", "W_exp", "flags"):
            table.add_column(name, justify="left" if name in ("condition", "bed", "flags") else "right")
        for key in list(self._sums)[-LINES:]:
            scene, drive = self._conditions[key].scene, self._conditions[key].drive
            found = self._sums[key]
            table.add_row(
                key, scene.bed, f"{scene.grains.fill:.0%}", f"{scene.grains.diameter * 1e3:g} mm",
                f"{drive.acceleration:g} m/s2", f"{len(found)}/{self._repeats}",
                f"{number(sum(found) / len(found))} J", " ".join(sorted(self._flags[key])),
            )  # fmt: skip
        return Group(self._bar, table)


@contextmanager
def live_view(campaign: Campaign, console: Console) -> Iterator[LiveView]:
    """A view that is drawn while the block runs."""
    view = LiveView(campaign, console)
    if console.is_terminal:
        with Live(view, console=console, refresh_per_second=4, transient=True):
            yield view
    else:
        yield view
