"""The choice of `fidelity: auto` for a condition."""

from dataclasses import asdict, dataclass, replace
from typing import Any

from rig.fidelity.scene_rows import with_rows
from rig.protocol.spec import Condition


@dataclass(frozen=True)
class FidelityChoice:
    """The choice for a condition and its errors, relative to W of the fully resolved scene.

    rows : per layer, None for a bed without rows
    written, resolved : (rows, settle, record) of the protocol and of the fully resolved scene
    error_rows, error_window, error_noise : parts of the error; that of the window covers settling
        and record together
    scatter, scatter_resolved : standard deviation of one refill's W due to the positions of the
        rows, with these rows and with the resolved ones
    averaged : cycles over which W_T averages rows without a period
    skipped : parts that are not simulated, and why
    row_cycles : row cycles per run as "auto", "written", "resolved"; "planning" : to make this
        choice, once
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
        """Predicted relative error."""
        return self.error_rows + self.error_window + self.error_noise

    @property
    def met(self) -> bool:
        """Whether the tolerance is met."""
        return self.error <= self.tolerance

    @property
    def why(self) -> str:
        """The reason why the tolerance is not met, "" if it is."""
        parts = {
            "rows": self.error_rows,
            "settling and record": self.error_window,
            "noise": self.error_noise,
        }
        largest = max(parts, key=lambda name: parts[name])
        return "" if self.met else f"{largest} leave {100 * parts[largest]:.2g} %"

    def document(self) -> dict[str, Any]:
        """Return the choice as plain data for the session."""
        return {**asdict(self), "error": self.error, "met": self.met, "why": self.why}

    def applied(self, condition: Condition) -> Condition:
        """Return the condition with the choice applied. Its seeds remain those of the condition as
        written.
        """
        scene = condition.scene if self.rows is None else with_rows(condition.scene, self.rows)
        return replace(
            condition,
            scene=scene,
            acquire=replace(condition.acquire, settle=self.settle, record=self.record),
        )
