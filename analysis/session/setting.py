"""The setting of a condition, read from the session's document and validated."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

from analysis.session.former_names import condition_today
from analysis.session.record import AnalysisError
from daq.documents.classes import LEFT_OUT, built, shape_of
from daq.documents.shapes import Choice, Keys, Number, Text, deviations

LOOP_BACK = "loop_back"  # no bed: one voltage at both inputs

SIZE, MASS = Number(0.0, 1e9), Number(0.0, 1e9)
ONE = Number(1e-9, 1e9)
Size = Annotated[float | None, SIZE]
Mass = Annotated[float, MASS]
One = Annotated[float, ONE]
Unset = Annotated[float | None, Number(), LEFT_OUT]
DELIBERATE_ERRORS = {
    "pole": {"value": ONE},
    "corners": {"corner": ONE},
    "cycles": {"value": ONE},
    "skew": {"delay": Number(-1e3, 1e3)},
    "clock": {},
    "coil": {},
    "offset": {},
    "friction": {"gravity": MASS},
}
DELIBERATE_ERROR = Choice(
    "kind",
    {kind: Keys({"value": Number(-1e9, 1e9), **more}) for kind, more in DELIBERATE_ERRORS.items()},
)


@dataclass(frozen=True, slots=True)
class SessionDeliberateError:
    """A deliberate error (analysis.results.deliberate_errors).

    value : its size
    corner, delay, gravity : further values that some kinds state, Hz, s and m/s^2
    """

    kind: str
    value: float
    corner: Unset = None
    delay: Unset = None
    gravity: Unset = None


@dataclass(frozen=True, slots=True)
class GasDrag:
    """The drag of the gas between the grains: whether it is switched on, and its largest value over
    the bed's weight.
    """

    on: bool
    share_of_weight: Mass


@dataclass(frozen=True, slots=True)
class NoiseAndAir:
    """A number for each of the losses `noise` and `air`."""

    noise: Annotated[float, Number(0.0)]
    air: Annotated[float, Number(0.0)]


@dataclass(frozen=True, slots=True)
class Setting:
    """The setting of a condition, SI units; None for values that nobody wrote down.

    carried : there is a bed, but nothing in it can slide
    dashpot_c : coefficient, N s/m; None for other beds
    deliberate_error : made on purpose (analysis.results.deliberate_errors)
    sweep_to : last frequency of a sweep that starts at `frequency`, Hz
    gauge, accelerometer : end of the stinger to which they are fixed; None where it is not stated
    losses, support : of the stand; "" where not stated
    varied : other settings that the protocol varied, in words by name
    over_first_principles : coefficients of the losses `noise` and `air` over sound and drag of the
        box
    loss_coefficients : the coefficients, N s/m and N s^2/m^2, where the rig file leaves them to
        first principles
    """

    id: str
    material: str
    density: Size
    diameter: Size
    fill: Size
    bed: str
    drive: str
    bed_mass: Mass
    carried: bool
    frequency: One
    acceleration_set: Mass
    settle_cycles: Mass
    record_cycles: Annotated[float, Number(1, 1e9, whole=True)]
    box_mass: Mass
    gauge_mass: Mass
    moving_mass: Mass
    dashpot_c: Size = None
    deliberate_error: Annotated[SessionDeliberateError | None, DELIBERATE_ERROR] = None
    sweep_to: Annotated[float | None, ONE] = None
    gauge: Annotated[str | None, Text()] = None
    accelerometer: Annotated[str | None, Text()] = None
    losses: tuple[str, ...] = ()
    support: str = ""
    gas: GasDrag | None = None
    over_first_principles: Annotated[NoiseAndAir | None, LEFT_OUT] = None
    loss_coefficients: Annotated[NoiseAndAir | None, LEFT_OUT] = None
    varied: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, condition: Mapping[str, Any]) -> "Setting":
        """Return the setting in a session's condition. AnalysisError naming the first key that is
        missing or wrong.
        """
        condition = condition_today(condition)
        for name in CONDITION.required:
            if name not in condition:
                raise AnalysisError(f"condition {condition.get('id', '?')} lacks {name!r}")
        for sentence in deviations(dict(condition), CONDITION, f"condition {condition['id']}"):
            raise AnalysisError(sentence)
        return built(cls, condition)

    @property
    def places(self) -> tuple[str | None, str | None]:
        """Positions of gauge and accelerometer: only conditions with equal positions are compared."""
        return self.gauge, self.accelerometer

    @property
    def through_stinger(self) -> bool:
        """Whether the acceleration is read at the far end of the stinger, whose compliance and loss
        it then includes.
        """
        return self.accelerometer == "exciter"

    @property
    def is_empty(self) -> bool:
        """Whether the box is empty: no grains, and no dashpot either."""
        return self.bed == "empty" or (
            self.bed not in ("dashpot", "unknown", LOOP_BACK) and self.bed_mass == 0
        )

    @property
    def is_bonded(self) -> bool:
        """Whether there are grains that cannot slide: bonded to the box, or packed too full to
        flow.
        """
        return not self.is_empty and (self.bed == "locked" or self.carried)

    @property
    def is_still(self) -> bool:
        """Whether nothing in the box can slide: it is empty, or its grains are bonded."""
        return self.is_empty or self.is_bonded


CONDITION = shape_of(Setting)
"""Schema of a condition in the session."""
