"""What is tested and how: SI numbers, no files. The annotations are the protocol's grammar:
meaning, unit and range of every field stand here once and the strict reader checks against them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from daq.documents.shapes import one_of, some_of
from rig.protocol.deliberate_errors import NO_DELIBERATE_ERROR, DeliberateError
from rig.protocol.faults import Fault
from rig.units import Quantity

SCHEMA = "rig/protocol/1"
BEDS = ("empty", "locked", "dashpot", "single_mass", "layers", "grains", "loop_back")
BUILT_BEDS = ("empty", "locked", "dashpot", "single_mass", "layers", "loop_back")
LOOP_BACK = "loop_back"  # no bed: the box stands by empty, and one voltage is led to all inputs
HORIZONTAL_ONLY_BEDS = ("layers",)
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


@dataclass(frozen=True)
class Cavity:
    """Inner sizes of the box and its wall thickness, m; `length` lies along a horizontal drive
    axis.
    """

    length: Size = 0.15
    width: Size = 0.15
    height: Size = 0.4
    wall: Small = 0.005


@dataclass(frozen=True)
class Grains:
    """Balls: catalog material, diameter in m, fill as a fraction of the cavity's volume; `density`
    in kg/m^3 overrides the catalog's (None until conditions are built)."""

    material: str = "stainless"
    diameter: Small = 0.004
    fill: Fraction = 0.85
    density: Annotated[float | None, Quantity("density", 0.0, 30000.0, above=True)] = None


@dataclass(frozen=True)
class Layers:
    """Bed `layers` (model.md, layers variant): mean clearance in units of dl, its relative spread,
    strata per layer.
    """

    clearance: Annotated[float, Quantity("number", 0.0, 1000.0)] = 1.0
    spread: Fraction = 0.5
    rows: Annotated[int, Quantity("number", 1, 10000)] = 8
    side_walls: bool = False


@dataclass(frozen=True)
class SingleMass:
    """Bed `single_mass`, all grains as one mass: restitution at floor, lid and end walls; free gap
    in m (None = from the fill, "none" = no walls and no lid; a vertical box keeps its floor);
    friction coefficient of a horizontal box's floor; where the mass starts, m above the floor or
    end wall (at most the gap), and how fast, m/s against the box."""

    restitution: Fraction = 0.0
    gap: Annotated[float | Literal["none"] | None, Quantity("length", 0.0, 20.0)] = None
    friction: Annotated[float, Quantity("number", 0.0, 10.0)] = 0.0
    start: Annotated[float, Quantity("length", 0.0, 20.0)] = 0.0
    velocity: Annotated[float, Quantity("velocity", -1000.0, 1000.0)] = 0.0


@dataclass(frozen=True)
class Dashpot:
    """Bed `dashpot`: a viscous damper to the ground, N s/m."""

    c: Annotated[float, Quantity("damping", 0.0, 1e9)] = 50.0


@dataclass(frozen=True)
class Scene:
    """The box, what is in it and what else takes energy from it."""

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
    """The motion asked for: frequency in Hz, peak acceleration in m/s^2; `imperfection` none for an
    exact waveform. Shaker-coupled drive: what the amplifier commands; the end of the stinger that
    the gauge and its mass are fixed to, and the accelerometer (both at the exciter: an impedance
    head); whether the level is controlled (from `below`, or coming down from `above`; `harmonics`
    of the acceleration, 1 for the amplitude alone; giving up after `timeout`) or a `command` is
    held, a share of the amplifier's limit. sweep_to: frequency that the record's cycles sweep to,
    in a straight line over time; None holds it."""

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
        """The highest frequency, Hz."""
        return self.frequency if self.sweep_to is None else max(self.frequency, self.sweep_to)

    def swept_time(self, cycles: float) -> float:
        """How long so many cycles of the record last, s."""
        return cycles / (
            self.frequency if self.sweep_to is None else 0.5 * (self.frequency + self.sweep_to)
        )


@dataclass(frozen=True)
class Sensors:
    """Catalog names of the transducers; "ideal" leaves one out. Voltage and current: of the
    exciter's coil.
    """

    force: str = "208C03"
    acceleration: str = "352C33"
    current: str = "shunt"
    voltage: str = "divider"


@dataclass(frozen=True)
class Coupling:
    """How the analyzer's inputs are coupled: DC, AC, or IEPE, which feeds the sensor and is AC
    coupled.
    """

    force: Coupled = "DC"
    acceleration: Coupled = "DC"


@dataclass(frozen=True)
class Ranges:
    """Input ranges in V, each +- that value: one of the analyzer's, "auto" for the smallest that
    the look ahead finds large enough, None for the rig file's."""

    force: Volts = None
    acceleration: Volts = None


@dataclass(frozen=True)
class Trigger:
    """What starts a record: a channel ("none": the drive's own start) that passes a level, a share
    of its range; what is kept from before; how long it is waited for. "edge": coming from the other
    side; "level": being beyond."""

    channel: Literal["none", "force", "acceleration", "current", "voltage"] = "none"
    level: Annotated[float, Quantity("number", -1.0, 1.0)] = 0.1
    slope: Literal["rising", "falling"] = "rising"
    kind: Literal["edge", "level"] = "edge"
    before: Annotated[int, Quantity("samples", 0, 1000000)] = 0
    patience: Annotated[int, Quantity("cycles", 1, 1000000)] = 100


@dataclass(frozen=True)
class Acquire:
    """The acquisition: catalog analyzer, least samples per cycle, cycles to settle and to record;
    whether coil current and drive voltage are recorded beside force and acceleration. `effects`:
    what else of the sensors' sheets is simulated."""

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
    """Runs per condition; `refill` draws a new packing for each."""

    n: Annotated[int, Quantity("number", 1, 10000)] = 4
    refill: bool = True


@dataclass(frozen=True)
class Condition:
    """One point of the grid with every value resolved. `seed_key` is the content that seeds its
    random streams: scene without losses and support, level and frequency, no acquisition: changing
    anything else keeps the bed."""

    id: str
    scene: Scene
    drive: Drive
    acquire: Acquire
    seed_key: str


@dataclass(frozen=True)
class Vary:
    """One axis of the grid: row k of `rows` holds the k-th value of each of `paths`. Several paths
    vary together.
    """

    paths: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]


@dataclass(frozen=True)
class Expect:
    """A claim to be judged (rig.protocol.claims has the grammar): its words, the kind of test, the
    path of the field it is about ("" for none), the values named in it, the conditions it is
    restricted to, the path it is averaged over, the limits fixed beforehand, and why its outcome is
    imposed ("" where it is not)."""

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
    """An experiment as written; the grid runs over `vary` in the order written, the last axis
    fastest.

    fidelity : auto finds rows per layer, settling and record for each condition, so that the error
        of W per cycle against the fully resolved scene stays within `tolerance` (None: 1 %)
    """

    name: str
    schema: str = SCHEMA
    rig: str = "paper"
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
