"""The values of the catalog: frozen SI numbers, each with its origin."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

from rig.units import GRAVITY, Quantity

STATUSES = ("sourced", "recalled", "computed", "assumed")

Positive = Annotated[float, Quantity("number", 0.0, 1e12, above=True)]
Fraction = Annotated[float, Quantity("number", 0.0, 1.0)]
Friction = Annotated[float, Quantity("number", 0.0, 10.0)]
Density = Annotated[float, Quantity("density", 0.0, 30000.0, above=True)]
Stiffness = Annotated[float, Quantity("stiffness", 0.0, 1e12, above=True)]
OwnFraction = Annotated[float | None, Quantity("number", 0.0, 1.0)]
OwnFriction = Annotated[float | None, Quantity("number", 0.0, 10.0)]


RANGES = {"force": 10.0, "acceleration": 1.0, "current": 10.0, "voltage": 10.0}
"""Default analyzer range of every channel that can be recorded, V."""


@dataclass(frozen=True)
class CatalogValue:
    """A number with its origin: `value` in the SI `unit`, `status` one of STATUSES, `source` in
    words.
    """

    path: str
    value: float | tuple[float, ...] | None
    unit: str
    status: str
    source: str


@dataclass(frozen=True)
class Material:
    """A material of grains or of the box: density kg/m^3, Young's modulus Pa, Poisson ratio.

    Contacts of its grains with each other and with the wall: coefficients of restitution and of
    friction, None where the rig's hold. `values` lists each number's origin.
    """

    name: str
    label: str
    density: Density
    youngs_modulus: Annotated[float, Quantity("pressure", 0.0, 2e12, above=True)]
    poisson_ratio: Annotated[float, Quantity("number", 0.0, 0.5)]
    restitution_grains: OwnFraction = None
    restitution_wall: OwnFraction = None
    grain_friction: OwnFriction = None
    wall_friction: OwnFriction = None
    values: tuple[CatalogValue, ...] = ()

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True)
class Exciter:
    """An electrodynamic exciter with its amplifier's limits and its stinger (hardware.md).

    Peak force N, force constant N/A, coil ohm and H, peak current A and voltage V, stroke +-m,
    masses kg, stiffnesses N/m, stinger damping N s/m, stinger buckling load N. The laboratory's
    knowledge of them: relative expanded uncertainties (k = 2) of the force constant,
    `force_constant_U`, and of each mass, stiffness and damping, `parts_U`.
    """

    name: str
    force_peak: Annotated[float, Quantity("force", 0.0, 1e7, above=True)]
    force_constant: Annotated[float, Quantity("force constant", 0.0, 1e5, above=True)]
    resistance: Annotated[float, Quantity("resistance", 0.0, 1e4, above=True)]
    inductance: Annotated[float, Quantity("inductance", 0.0, 10.0)]
    current_peak: Annotated[float, Quantity("current", 0.0, 1e5, above=True)]
    voltage_peak: Annotated[float, Quantity("voltage", 0.0, 1e5, above=True)]
    stroke: Annotated[float, Quantity("length", 0.0, 1.0, above=True)]
    moving_mass: Annotated[float, Quantity("mass", 0.0, 1e4, above=True)]
    flexure_stiffness: Stiffness
    flexure_damping_ratio: Fraction
    body_mass: Annotated[float, Quantity("mass", 0.0, 1e6, above=True)]
    isolation_stiffness: Stiffness
    isolation_damping_ratio: Fraction
    stinger_stiffness: Stiffness
    stinger_damping: Annotated[float, Quantity("damping", 0.0, 1e6)]
    stinger_buckling: Annotated[float, Quantity("force", 0.0, 1e9, above=True)]
    force_constant_U: Fraction
    parts_U: Fraction


@dataclass(frozen=True)
class Rig:
    """Everything about the stand that a protocol does not state.

    Every number is a field of the rig file.

    wall_friction mu_s, janssen_ratio K_p and grain_friction mu_p of eqs 1-5; restitutions; volume
    fractions of the shaken and the loose packing; wall density kg/m^3; gauge-side mass kg; gravity
    m/s^2; parasitic losses `loss_noise` (viscous, N s/m) and `loss_air` (quadratic, N s^2/m^2), None for
    the sound that the box radiates and the drag of the air on it by first principles; the
    mount: friction of guides, natural frequency in Hz and loss factor of cords; relative level
    error and third harmonic of the waveform; relative scatter per refill of the packing and of the
    clearance; analyzer range of each channel in V (keys of `RANGES`); `provenance` of the losses as
    `rig calibrate` wrote it; `values` lists every number's origin.
    """

    name: str
    exciter: Exciter
    wall_friction: Friction = 0.45
    janssen_ratio: Annotated[float, Quantity("number", 0.0, 10.0)] = 0.7
    grain_friction: Friction = 0.25
    restitution_grains: Fraction = 0.90
    restitution_wall: Fraction = 0.75
    packing_shaken: Annotated[float, Quantity("number", 0.0, 0.75, above=True)] = 0.63
    packing_loose: Annotated[float, Quantity("number", 0.0, 0.75, above=True)] = 0.57
    wall_density: Density = 7850.0
    gauge_mass: Annotated[float, Quantity("mass", 0.0, 100.0)] = 0.02
    gravity: Annotated[float, Quantity("acceleration", 0.0, 1000.0)] = GRAVITY
    loss_noise: Annotated[float | None, Quantity("damping", 0.0, 1e9, null=True)] = None
    loss_air: Annotated[float | None, Quantity("quadratic damping", 0.0, 1e9, null=True)] = None
    guide_friction: Friction = 0.006
    cord_frequency: Annotated[float, Quantity("frequency", 0.0, 10000.0, above=True)] = 2.0
    cord_loss_factor: Friction = 0.1
    level_error: Fraction = 0.003
    third_harmonic: Fraction = 0.003
    refill_packing: Fraction = 0.01
    refill_clearance: Fraction = 0.10
    ranges: Mapping[str, float] = field(default_factory=lambda: dict(RANGES), hash=False)
    provenance: Mapping[str, Any] = field(default_factory=dict, hash=False)
    values: tuple[CatalogValue, ...] = ()
