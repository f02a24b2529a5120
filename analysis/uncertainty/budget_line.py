"""A line of an uncertainty budget."""

from dataclasses import dataclass

__all__ = ["Line"]


@dataclass(frozen=True, slots=True)
class Line:
    """A line of an uncertainty budget: one input quantity.

    u, unit, nu : standard uncertainty, its unit and its degrees of freedom
    c, c_T : sensitivity of W_exp and of W_T, J per unit
    shared : the same error in every condition
    ratio, turn : change of force over acceleration per unit: relative magnitude, and angle in rad,
        positive where it raises W; apparent mass and loss factor follow from them (`mass_and_loss`)
    stretch : factor in u, of the scatter between runs (`analysis.uncertainty.skewed_scatter`)
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
