"""A condition as a session's document states it, checked."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from analysis.session.record import AnalysisError
from daq.documents.shapes import Choice, Either, Keys, List, Null, Number, Text, YesNo, deviations

LOOP_BACK = "loop_back"  # a bed that is none: one voltage at both inputs

SIZE, MASS = Number(0.0, 1e9, null=True), Number(0.0, 1e9)
ONE = Number(1e-9, 1e9)
MISTAKES = {
    "pole": {"value": ONE}, "corners": {"corner": ONE}, "cycles": {"value": ONE}, "skew": {"delay": Number(-1e3, 1e3)},
    "clock": {}, "coil": {}, "offset": {}, "friction": {"gravity": MASS},
}  # fmt: skip
MISTAKE = Choice("kind", {kind: Keys({"value": Number(-1e9, 1e9), **more}) for kind, more in MISTAKES.items()})
CONDITION = Keys(
    {
        "id": Text(), "material": Text(), "density": SIZE, "diameter": SIZE, "fill": SIZE, "bed": Text(),
        "drive": Text(), "bed_mass": MASS, "carried": YesNo(), "frequency": ONE, "acceleration_set": MASS,
        "settle_cycles": MASS, "record_cycles": Number(1, 1e9, whole=True), "box_mass": MASS, "gauge_mass": MASS,
        "moving_mass": MASS,
    },
    {
        "dashpot_c": SIZE, "sweep_to": Either(Null(), ONE), "mistake": Either(Null(), MISTAKE), "losses": List(Text()),
        "support": Text(), "gauge": Either(Null(), Text()), "accelerometer": Either(Null(), Text()),
        "gas": Keys({"on": YesNo(), "share_of_weight": MASS}, null=True),
        "over_first_principles": Keys({"noise": Number(0.0), "air": Number(0.0)}),
    },
)  # fmt: skip
"""A condition in the session (SI): what `Setting` takes, and what the table of causes asks for."""


@dataclass(frozen=True, slots=True)
class Setting:
    """A condition: what was set, as the session says. SI units, None for what nobody wrote down.

    carried: a bed is there but nothing in it can slide; dashpot_c: N s/m of a dashpot, None for other beds; mistake:
    what is deliberately done wrong (analysis.results.deliberate_errors); sweep_to: Hz, of a record that sweeps there
    from `frequency`; gauge, accelerometer: the end of the stinger that they are fixed to, None where nobody says.
    """

    id: str
    material: str
    density: float | None
    diameter: float | None
    fill: float | None
    bed: str
    drive: str
    bed_mass: float
    carried: bool
    frequency: float
    acceleration_set: float
    settle_cycles: float
    record_cycles: float
    box_mass: float
    gauge_mass: float
    moving_mass: float
    dashpot_c: float | None = None
    mistake: Mapping[str, Any] | None = None
    sweep_to: float | None = None
    gauge: str | None = None
    accelerometer: str | None = None

    @classmethod
    def of(cls, condition: Mapping[str, Any]) -> "Setting":
        """The setting in a session's condition. AnalysisError naming the first key that is missing or wrong."""
        known = {
            "dashpot_c": None,
            "mistake": None,
            "sweep_to": None,
            "gauge": None,
            "accelerometer": None,
            **condition,
        }
        for name in cls.__slots__:
            if name not in known:
                raise AnalysisError(f"condition {condition.get('id', '?')} lacks {name!r}")
        for sentence in deviations(dict(known), CONDITION, f"condition {known['id']}"):
            raise AnalysisError(sentence)
        return cls(**{name: known[name] for name in cls.__slots__})

    @property
    def places(self) -> tuple[str | None, str | None]:
        """Where gauge and accelerometer are: what is read at different places is compared with nothing."""
        return self.gauge, self.accelerometer

    @property
    def through_stinger(self) -> bool:
        """Whether the acceleration is read at the far end of the stinger, whose give and loss are then in it."""
        return self.accelerometer == "exciter"

    @property
    def is_empty(self) -> bool:
        """Nothing in the box: no grains, and no dashpot either."""
        return self.bed == "empty" or (self.bed not in ("dashpot", "unknown", LOOP_BACK) and self.bed_mass == 0)

    @property
    def is_bonded(self) -> bool:
        """Grains are in the box and cannot slide: bonded to it, or packed too full to flow."""
        return not self.is_empty and (self.bed == "locked" or self.carried)
