"""A line of an uncertainty budget."""

from dataclasses import dataclass

__all__ = ["Line"]


@dataclass(frozen=True, slots=True)
class Line:
    """A line of the budget. unit: of u; c, c_T: J per that unit; shared: the same error in every
    condition.

    ratio, turn: what a unit of it does to force over acceleration: relative size, and angle in rad,
    counted in the direction that raises W. Apparent mass and loss factor follow from these two
    (`mass_and_loss`). stretch: factor in u, of the scatter between runs
    (`analysis.uncertainty.skewed_scatter`).
    """

    source: str
    unit: str
    u: float
    nu: float
    c: float
    c_T: float = 0.0
    shared: bool = True
    ratio: float = 0.0
    turn: float = 0.0
    stretch: float = 1.0

    @property
    def part(self) -> float:
        """Contribution to W_exp, J, with its sign."""
        return self.c * self.u

    @property
    def part_T(self) -> float:
        """Contribution to W_T, J, with its sign."""
        return self.c_T * self.u
