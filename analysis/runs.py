"""What the analysis needs of a record, and what it makes of one run."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from analysis.energy import Energy
from daq.shapes import Choice, Either, Keys, List, Null, Number, Text, YesNo, deviations

if TYPE_CHECKING:
    from analysis.coil import Coil
    from analysis.gauge import AtBox

__all__ = [
    "CONDITION",
    "LOOP_BACK",
    "AnalysisError",
    "ChannelFacts",
    "Record",
    "RunEnergy",
    "RunFacts",
    "Setting",
    "Signal",
    "Truth",
]


LOOP_BACK = "loop_back"  # a bed that is none: one voltage at both inputs


class AnalysisError(Exception):
    """A record or a run cannot be analysed; the message says which and why."""


class ChannelFacts(Protocol):
    """The row of the channel table that corrections and uncertainties are made from (certified values, SI)."""

    @property
    def name(self) -> str: ...
    @property
    def unit(self) -> str: ...
    @property
    def model(self) -> str: ...
    @property
    def scale(self) -> float: ...
    @property
    def sensitivity(self) -> float: ...
    @property
    def time_constant(self) -> float | None: ...
    @property
    def time_constant_spread(self) -> float: ...
    @property
    def filter_delay(self) -> float: ...
    @property
    def skew(self) -> float: ...
    @property
    def calibration_U(self) -> float: ...
    @property
    def gain_tolerance(self) -> float: ...
    @property
    def clock_ppm(self) -> float: ...
    @property
    def noise_rms(self) -> float: ...
    @property
    def time_constants(self) -> tuple[float, ...]: ...
    @property
    def corner(self) -> float: ...
    @property
    def corner_tolerance(self) -> float: ...
    @property
    def skew_tolerance(self) -> float: ...
    @property
    def flicker(self) -> float: ...
    @property
    def full_scale(self) -> float: ...
    @property
    def linearity(self) -> float: ...
    @property
    def clips_at(self) -> float: ...


class RunFacts(Protocol):
    """A run as the record lists it."""

    @property
    def name(self) -> str: ...
    @property
    def condition(self) -> str: ...
    @property
    def repeat(self) -> int: ...
    @property
    def order(self) -> int: ...
    @property
    def samples(self) -> int: ...
    @property
    def complete(self) -> bool: ...
    @property
    def flags(self) -> int: ...
    @property
    def rate(self) -> float: ...


class Signal(Protocol):
    """Samples in engineering units, with the quality bits of the blocks they came in."""

    @property
    def samples(self) -> NDArray[np.float64]: ...
    @property
    def flags(self) -> int: ...


class Truth(Protocol):
    """What only a simulated session knows."""

    def ledger(
        self, run: str, start: int = 0, stop: int | None = None
    ) -> tuple[tuple[str, ...], NDArray[np.float64]]: ...
    def document(self, name: str) -> Any: ...


class Record(Protocol):
    """The part of daq.session.Record that is read here; any source of records may offer the same."""

    @property
    def runs(self) -> tuple[RunFacts, ...]: ...
    @property
    def conditions(self) -> Mapping[str, Mapping[str, Any]]: ...
    @property
    def channels(self) -> Mapping[str, ChannelFacts]: ...
    @property
    def synthetic(self) -> bool: ...
    @property
    def truth(self) -> Truth | None: ...
    def run(self, name: str) -> RunFacts: ...
    def signal(self, run: str, name: str, start: int = 0, stop: int | None = None) -> Signal: ...
    def document(self, name: str) -> Any: ...
    def scalars(self, run: str) -> Mapping[str, float]: ...
    def blocks(self, run: str) -> NDArray[np.void]: ...


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
    what is deliberately done wrong (analysis.mistakes); sweep_to: Hz, of a record that sweeps there
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


@dataclass(frozen=True, eq=False)
class RunEnergy:
    """Energies of one run.

    flags: names of quality bits in the window and of limits exceeded. u_noise: J per cycle, standard deviation of W
    from the instruments' noise. ledger: true energies in J per cycle, means over the same cycles (simulated sessions
    only); its `closure` is the largest relative error of the account. use: shares of the exciter's limits (1 = at it).
    coil: energy as the coil's current tells it, None where that is not recorded. at_box: the same run compensated for
    place and mass of the gauge, None where the stinger is not known. recorded: what is predicted on the
    waveform that this run recorded, J per cycle, None where it was not computed; u_recorded: its standard uncertainty
    from what the bed went through before. clip_ratio: share of samples at a rail, of the channel that has most.
    """

    run: str
    condition: str
    repeat: int
    order: int
    energy: Energy
    u_noise: float = 0.0
    flags: tuple[str, ...] = ()
    ledger: Mapping[str, float] | None = None
    use: Mapping[str, float] = field(default_factory=dict)
    coil: "Coil | None" = None
    at_box: "AtBox | None" = None
    recorded: float | None = None
    u_recorded: float = 0.0
    clip_ratio: float = 0.0
