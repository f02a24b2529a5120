"""The live view of a running campaign, in 80 columns.

A bar with the time left, the levels of the channels with their overload flags, W of the latest
cycles, and a table that fills as runs are analysed.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rich.console import Console, Group
from rich.live import Live
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from daq.chain.clock import NEVER_LATE
from daq.strange_text import visible
from rig.cli.terminal.tables import number, scaled

if TYPE_CHECKING:
    from rig.campaign.campaign import Campaign
    from rig.campaign.one_run.live import LiveUpdate
    from rig.campaign.one_run.recorder import Progress as Step

LINES = 12
"""Number of conditions shown: the last that changed."""

BAR = 24
"""Length of a level's bar in characters; full at the end of the range."""


@dataclass(frozen=True)
class ConditionLine:
    """A condition's settings in the view (SI), and its number of runs."""

    bed: str
    fill: float | None
    diameter: float | None
    acceleration: float
    runs: int


def lines_of(campaign: "Campaign") -> dict[str, ConditionLine]:
    """Return the view's lines for the conditions of a campaign, by id."""
    repeats = campaign.protocol.repeats.n
    return {
        c.id: ConditionLine(
            c.scene.bed, c.scene.grains.fill, c.scene.grains.diameter, c.drive.acceleration, repeats
        )
        for c in campaign.conditions
    }


class LiveView:
    """Shows a campaign's progress: drawn on a terminal, elsewhere one line for every tenth of the
    runs.
    """

    def __init__(self, lines: Mapping[str, ConditionLine], console: Console) -> None:
        self._console = console
        self._sums: dict[str, list[float]] = {}
        self._flags: dict[str, set[str]] = {}
        self._lines = lines
        self._bar = Progress(
            TextColumn("runs"),
            BarColumn(bar_width=30),
            TextColumn("{task.fields[done]}/{task.total:.0f}"),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            console=console,
        )
        self._task = self._bar.add_task(
            "runs", total=sum(line.runs for line in lines.values()), done=0
        )
        self._done = 0
        # Fractions of the runs that are being recorded, by name.
        self._under_way: dict[str, float] = {}
        self._latest: LiveUpdate | None = None
        self._worst: dict[str, float] = {}
        self._lamps: dict[str, set[str]] = {}
        self.punctuality = NEVER_LATE

    @property
    def looks(self) -> bool:
        """Whether updates for single blocks are shown at all."""
        return self._console.is_terminal

    def look(self, look: "LiveUpdate") -> None:
        """Show a block that has been recorded."""
        self._latest = look
        for name, level in look.levels.items():
            self._worst[name] = max(self._worst.get(name, 0.0), level)
            self._lamps.setdefault(name, set()).update(set(look.flags[name]) - {"not_settled"})
        self._under_way[look.run] = look.samples / look.planned
        self._advance()

    def _advance(self) -> None:
        self._under_way = {name: done for name, done in self._under_way.items() if done < 1.0}
        self._bar.update(
            self._task, completed=self._done + sum(self._under_way.values()), done=self._done
        )

    def step(self, step: "Step") -> None:
        """Show a finished run."""
        # Popped and added again: the condition that changed last moves to the end, and the table
        # shows the end.
        found = self._sums.pop(step.condition, [])
        self._sums[step.condition] = (
            found if step.energy is None else [*found, step.energy.energy.W]
        )
        flags = ("unusable",) if step.energy is None else step.energy.flags
        self._flags.setdefault(step.condition, set()).update(flags)
        self._done = step.done
        self._under_way.pop(step.run, None)
        self.punctuality += step.punctuality
        self._advance()
        if (
            not self._console.is_terminal
            and (10 * step.done) // step.total != (10 * (step.done - 1)) // step.total
        ):
            self._console.print(f"{step.done} of {step.total} runs")

    def __rich__(self) -> Group:
        table = Table(box=None, pad_edge=False)
        for name in ("condition", "bed", "fill", "d", "a", "runs", "W_exp", "flags"):
            table.add_column(
                name, justify="left" if name in ("condition", "bed", "flags") else "right"
            )
        for key in list(self._sums)[-LINES:]:
            line, found = self._lines[key], self._sums[key]
            table.add_row(
                key, line.bed, f"{scaled(line.fill, 100)} %", f"{scaled(line.diameter, 1e3)} mm",
                f"{line.acceleration:g} m/s2", f"{len(found)}/{line.runs}",
                f"{number(sum(found) / len(found))} J" if found else "-",
                " ".join(sorted(self._flags[key])),
            )  # fmt: skip
        return Group(self._bar, *self._levels(), table)

    def _levels(self) -> list[Text]:
        """Return one line per channel, and one for the run of the latest block."""
        look = self._latest
        if look is None:
            return []
        lines = []
        for name, level in look.levels.items():
            filled = min(round(BAR * level), BAR)
            line = Text(
                f"{visible(name):<13}{'#' * filled}{'.' * (BAR - filled)} {level:4.0%} worst {self._worst[name]:4.0%}"
            )
            line.append(f" of {look.ranges[name]:g} V ")
            line.append(" ".join(sorted(self._lamps[name])).upper(), style="bold red")
            lines.append(line)
        energy = f", W {1e3 * sum(look.W) / len(look.W):.5g} mJ" if look.W else ""
        told = visible(f"{look.run} ({look.condition}): cycle {look.cycles} of {look.of}{energy}")
        lines.append(Text(told))
        return lines


def timing(view: LiveView) -> str:
    """Return the lateness of a paced campaign's blocks as a sentence, "" where none was paced."""
    late = view.punctuality
    if not late.count:
        return ""
    told = (1e3 * value for value in (late.mean, late.jitter, late.worst))
    mean, jitter, worst = (f"{ms:.0f} ms" if ms >= 10 else f"{ms:.2g} ms" for ms in told)
    return f"paced: {late.count} blocks, late by {mean} in the mean (jitter {jitter}), {worst} at worst"


@contextmanager
def live_view(lines: Mapping[str, ConditionLine], console: Console) -> Iterator[LiveView]:
    """Yield a view that is drawn while the block runs."""
    view = LiveView(lines, console)
    if console.is_terminal:
        with Live(view, console=console, refresh_per_second=4, transient=True):
            yield view
    else:
        yield view
