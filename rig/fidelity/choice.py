"""What `fidelity: auto` chose for a condition."""

from dataclasses import asdict, dataclass, replace
from typing import Any

from rig.fidelity.scene_rows import with_rows
from rig.protocol.spec import Condition


@dataclass(frozen=True)
class Choice:
    """What was chosen for a condition, and what it costs in accuracy, relative to W of the fully resolved scene.

    rows : per layer, None for a bed without; written, resolved : (rows, settle, record) of the protocol and of the
        fully resolved scene
    error_rows, error_window, error_noise : parts of the error; the window's is that of settling and record together
    scatter, scatter_resolved : of one pouring's W from where the rows lie, with these rows and with the resolved ones
    averaged : cycles over which W_T averages rows without a period
    skipped : what is not simulated, and why
    row_cycles : cycles of rows that a run holds, by "auto", "written", "resolved"; "planning" : to find this out, once
    """

    tolerance: float
    rows: int | None
    settle: int
    record: int
    written: tuple[int, int, int]
    resolved: tuple[int, int, int]
    error_rows: float
    error_window: float
    error_noise: float
    scatter: float
    scatter_resolved: float
    averaged: int
    skipped: tuple[str, ...]
    row_cycles: dict[str, int]

    @property
    def error(self) -> float:
        """Predicted error."""
        return self.error_rows + self.error_window + self.error_noise

    @property
    def met(self) -> bool:
        """Whether the tolerance is met."""
        return self.error <= self.tolerance

    @property
    def why(self) -> str:
        """What keeps the tolerance from being met, "" where it is."""
        parts = {"rows": self.error_rows, "settling and record": self.error_window, "noise": self.error_noise}
        largest = max(parts, key=lambda name: parts[name])
        return "" if self.met else f"{largest} leave {100 * parts[largest]:.2g} %"

    def document(self) -> dict[str, Any]:
        """As plain data for the session."""
        return {**asdict(self), "error": self.error, "met": self.met, "why": self.why}

    def applied(self, condition: Condition) -> Condition:
        """The condition with what was chosen. Its seeds stay: they hang on the condition as written."""
        scene = condition.scene if self.rows is None else with_rows(condition.scene, self.rows)
        return replace(
            condition, scene=scene, acquire=replace(condition.acquire, settle=self.settle, record=self.record)
        )
