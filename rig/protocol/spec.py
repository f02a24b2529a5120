"""The experiment as typed data: numbers in SI units, no files.

The annotations are the grammar of protocols: type, unit and range of each field are written here
once. The strict reader checks a file against them; JSON Schema and docs/fields.md are made from
them, and a class's docstring is its description in the schema.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from daq.documents.shapes import one_of, some_of
from rig.catalog.entries import Material
from rig.catalog.stated_values import MATERIAL
from rig.protocol.deliberate_errors import NO_DELIBERATE_ERROR, DeliberateError
from rig.protocol.faults import Fault
from rig.units import Quantity

SCHEMA = "rig/protocol/1"
BEDS = ("empty", "locked", "dashpot", "single_mass", "layers", "column", "grains", "loop_back")
BUILT_BEDS = ("empty", "locked", "dashpot", "single_mass", "layers", "column", "loop_back")
LOOP_BACK = "loop_back"  # no bed: the box is empty and one voltage is connected to all inputs
HORIZONTAL_ONLY_BEDS = ("layers", "column")
RIGID_BEDS = ("empty", "locked", "dashpot", "loop_back")  # nothing slides or flies in them
BEDS_OF_GRAINS = ("layers", "column", "grains")
BEDS_OF_ROWS = ("layers", "column")  # beds made of rows that slide in the box
PREDICTIONS = ("layers", "column", "as_printed", "own", "band")
LOCKING_LEVEL = 3.3
"""Level a/g up to which vertical grains fly and land as one mass, once a cycle: sqrt(1 + pi^2)."""

LOSSES = ("noise", "air", "gas", "mount")
MODES = ("prescribed", "shaker")
BUILT_MODES = ("prescribed", "shaker")
EFFECTS = ("linearity", "resonance", "flicker")


Size = Annotated[float, Quantity("length", 0.0, 20.0, above=True)]
Small = Annotated[float, Quantity("length", 0.0, 0.5, above=True)]
Fraction = Annotated[float, Quantity("number", 0.0, 1.0)]
Axis = Literal["horizontal", "vertical", "zero_gravity"]
Support = Literal["none", "cords", "guide"]
Mode = Literal["prescribed", "shaker"]
Imperfection = Literal["default", "none"]
Amplifier = Literal["voltage", "current"]
GaugeSide = Literal["box", "exciter"]
Control = Literal["level", "open"]
Approach = Literal["below", "above"]
Coupled = Literal["DC", "AC", "IEPE"]
Volts = Annotated[float | Literal["auto"] | None, Quantity("voltage", 0.0, 1000.0, above=True)]
Fidelity = Literal["as_written", "auto"]
Density = Annotated[float | None, Quantity("density", 0.0, 30000.0, above=True)]
Named = Literal["layers", "column", "as_printed", "own", "band"]


@dataclass(frozen=True)
class Cavity:
    """Inner dimensions of the box and its wall thickness, m. `length` lies along the drive axis
    where that is horizontal. Material of the walls: a name or one's own values; null is that of the
    rig, whose `wall_density` is carbon steel's. `density` in kg/m^3 replaces the material's.
    """

    length: Size = 0.15
    width: Size = 0.15
    height: Size = 0.4
    wall: Small = 0.005
    material: Annotated[str | Material | None, MATERIAL] = None
    density: Density = None


@dataclass(frozen=True)
class Grains:
    """Balls: material, a name or one's own values; diameter in m, fill as a fraction of the
    cavity's volume. `density` in kg/m^3 replaces the material's; null takes the material's when the
    conditions are built."""

    material: Annotated[str | Material, MATERIAL] = "stainless"
    diameter: Small = 0.004
    fill: Fraction = 0.85
    density: Density = None


@dataclass(frozen=True)
class Layers:
    """Bed `layers` (docs/model.md): mean clearance in units of dl, relative spread of the clearance
    over the rows of a layer, rows per layer, and whether the layers rub on the two side walls along
    the drive.
    """

    clearance: Annotated[float, Quantity("number", 0.0, 1000.0)] = 1.0
    spread: Fraction = 0.5
    rows: Annotated[int, Quantity("number", 1, 10000)] = 8
    side_walls: bool = False


@dataclass(frozen=True)
class SingleMass:
    """Bed `single_mass`, all grains as one mass: coefficient of restitution at floor, lid and end
    walls; free gap in m (null: from the fill; "none": no walls and no lid, but a vertical box keeps
    its floor); friction coefficient of the floor of a horizontal box; initial position in m above
    the floor or from the end wall, at most the gap; initial velocity relative to the box, m/s."""

    restitution: Fraction = 0.0
    gap: Annotated[float | Literal["none"] | None, Quantity("length", 0.0, 20.0)] = None
    friction: Annotated[float, Quantity("number", 0.0, 10.0)] = 0.0
    start: Annotated[float, Quantity("length", 0.0, 20.0)] = 0.0
    velocity: Annotated[float, Quantity("velocity", -1000.0, 1000.0)] = 0.0


@dataclass(frozen=True)
class Dashpot:
    """Bed `dashpot`: a viscous damper from the box to the ground, damping `c` in N s/m."""

    c: Annotated[float, Quantity("damping", 0.0, 1e9)] = 50.0


@dataclass(frozen=True)
class Scene:
    """The box, its bed, its support, and the losses besides the bed."""

    cavity: Cavity = Cavity()
    axis: Axis = "horizontal"
    grains: Grains = Grains()
    bed: Annotated[str, one_of(*BEDS)] = "layers"
    losses: Annotated[tuple[str, ...], some_of(*LOSSES)] = ("noise", "air")
    support: Support = "none"
    layers: Layers = Layers()
    single_mass: SingleMass = SingleMass()
    dashpot: Dashpot = Dashpot()


@dataclass(frozen=True)
class Drive:
    """The drive: frequency in Hz, peak acceleration in m/s^2; `imperfection` none for an exact
    waveform. The further fields belong to the shaker-coupled drive. `amplifier`: quantity that the
    amplifier controls. `gauge`, `accelerometer`: end of the stinger where the force gauge (with its
    mass) and the accelerometer are mounted; both at the exciter make an impedance head. `control`
    level: the level is controlled, approached from `below` or `above`, with `harmonics` of the
    acceleration controlled (1: the amplitude alone), and given up after `timeout`. `control` open:
    `command` is held, a fraction of the amplifier's limit. `sweep_to`: frequency at the end of the
    record, reached linearly in time; null keeps the frequency constant."""

    mode: Mode = "prescribed"
    frequency: Annotated[float, Quantity("frequency", 0.0, 10000.0, above=True)] = 20.0
    acceleration: Annotated[float, Quantity("acceleration", 0.0, 10000.0, above=True)] = 5.0
    imperfection: Imperfection = "default"
    amplifier: Amplifier = "voltage"
    gauge: GaugeSide = "box"
    accelerometer: GaugeSide = "box"
    control: Control = "level"
    command: Annotated[float, Quantity("number", 0.0, 10.0, above=True)] = 0.1
    approach: Approach = "below"
    harmonics: Annotated[int, Quantity("number", 1, 40)] = 1
    timeout: Annotated[int, Quantity("cycles", 1, 100000)] = 60
    sweep_to: Annotated[float | None, Quantity("frequency", 0.0, 10000.0, above=True)] = None

    @property
    def fastest(self) -> float:
        """Return the highest frequency of the record, Hz."""
        return self.frequency if self.sweep_to is None else max(self.frequency, self.sweep_to)

    def swept_time(self, cycles: float) -> float:
        """Return the duration of `cycles` cycles of the record, s.

        A sweep is linear in time, so that its mean frequency is the mean of its two ends.
        """
        last = self.frequency if self.sweep_to is None else self.sweep_to
        return cycles / (0.5 * (self.frequency + last))


@dataclass(frozen=True)
class Sensors:
    """Catalog names of the transducers; "ideal" stands for an error-free one. Voltage and current
    are those of the exciter's coil.
    """

    force: str = "208C03"
    acceleration: str = "352C33"
    current: str = "shunt"
    voltage: str = "divider"


@dataclass(frozen=True)
class Coupling:
    """Coupling of the analyzer's inputs: DC, AC, or IEPE (AC coupled, with the sensor's supply
    current).
    """

    force: Coupled = "DC"
    acceleration: Coupled = "DC"


@dataclass(frozen=True)
class Ranges:
    """Input ranges in V, each +- that value: one of the analyzer's; "auto" for the smallest that
    the dry run before the session finds large enough; null for the rig file's."""

    force: Volts = None
    acceleration: Volts = None


@dataclass(frozen=True)
class Trigger:
    """Start of a record: when `channel` passes `level`, a fraction of the channel's range ("none":
    the record starts with the drive). `kind` edge: the signal crosses the level in the direction of
    `slope`; level: it is beyond the level. `before`: samples kept from before the trigger.
    `patience`: cycles after which a run without a trigger is given up."""

    channel: Literal["none", "force", "acceleration", "current", "voltage"] = "none"
    level: Annotated[float, Quantity("number", -1.0, 1.0)] = 0.1
    slope: Literal["rising", "falling"] = "rising"
    kind: Literal["edge", "level"] = "edge"
    before: Annotated[int, Quantity("samples", 0, 1000000)] = 0
    patience: Annotated[int, Quantity("cycles", 1, 1000000)] = 100


@dataclass(frozen=True)
class Acquire:
    """The acquisition: catalog analyzer, smallest number of samples per cycle, cycles to settle and
    to record. `paper_rule`: refuse fewer than 500 samples per cycle. `exciter_channels`: record
    coil current and drive voltage beside force and acceleration. `effects`: effects of the sensors'
    data sheets that are simulated in addition."""

    analyzer: str = "INV-3118"
    samples_per_cycle: Annotated[int, Quantity("number", 8, 1000000)] = 500
    settle: Annotated[int, Quantity("cycles", 1, 10000000)] = 10
    record: Annotated[int, Quantity("cycles", 1, 10000000)] = 40
    sensors: Sensors = Sensors()
    paper_rule: bool = True
    exciter_channels: bool = False
    coupling: Coupling = Coupling()
    ranges: Ranges = Ranges()
    effects: Annotated[tuple[str, ...], some_of(*EFFECTS)] = ()
    trigger: Trigger = Trigger()


@dataclass(frozen=True)
class Repeats:
    """Number of runs per condition; with `refill` the grains are packed anew for each."""

    n: Annotated[int, Quantity("number", 1, 10000)] = 4
    refill: bool = True


@dataclass(frozen=True)
class Condition:
    """One point of the grid with every value resolved.

    seed_key : hash of the content that seeds its random streams (rig.protocol.seed_keys). Losses,
        support and acquisition are no part of it: the bed stays the same when they change.
    prediction : name of the one that W_T is of; None for the bed's default
    """

    id: str
    scene: Scene
    drive: Drive
    acquire: Acquire
    seed_key: str
    prediction: Named | None = None

    @property
    def has_level(self) -> bool:
        """Whether a level is set, for which W_T of a sine can be predicted: not in open loop."""
        return self.drive.mode == "prescribed" or self.drive.control == "level"


@dataclass(frozen=True)
class Vary:
    """One axis of the grid: `rows[k]` holds the k-th value of each of `paths`, which vary together."""

    paths: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]


@dataclass(frozen=True)
class Expect:
    """A claim to be judged; rig.protocol.claims has its grammar.

    claim : the claim in words
    kind : the kind of test
    path : of the field that the claim is about, "" for none
    values : the values of that field that the claim names
    at : path -> values that restrict the claim to some conditions
    over : path of the field that ln W is averaged over, "" for none
    limits : limits fixed before the measurement
    imposed : reason why the outcome was put in, "" where it was not
    """

    claim: str
    kind: str
    path: str = ""
    values: tuple[Any, ...] = ()
    at: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    over: str = ""
    limits: tuple[float, ...] = ()
    imposed: str = ""


@dataclass(frozen=True)
class Protocol:
    """An experiment as written. The grid has the axes of `vary` in the order written, the last one
    fastest. With `fidelity` auto, rows per layer, settling and record are chosen for each
    condition, so that the error of W per cycle against the fully resolved scene stays within
    `tolerance` (null: 1 %). `prediction` names the W_T that the headline compares with; null is the
    bed's default: layers for bed layers, the bed's own where there is one, else column where it is
    stated, else a band."""

    name: str
    schema: str = SCHEMA
    rig: str = "clean"
    question: str = ""
    scene: Scene = Scene()
    drive: Drive = Drive()
    acquire: Acquire = Acquire()
    vary: tuple[Vary, ...] = ()
    repeats: Repeats = Repeats()
    seed: Annotated[int, Quantity("number", 0, 2**63 - 1)] = 2015
    faults: tuple[Fault, ...] = ()
    expect: tuple[Expect, ...] = ()
    deliberate_error: DeliberateError = NO_DELIBERATE_ERROR
    fidelity: Fidelity = "as_written"
    tolerance: Annotated[float | None, Quantity("number", 0.0, 1.0, above=True)] = None
    prediction: Named | None = None
