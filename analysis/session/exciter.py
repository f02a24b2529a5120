"""The documents of a session about its exciter and about the true state of its instruments."""

from dataclasses import dataclass
from typing import Annotated

from daq.documents.shapes import Number

__all__ = ["SessionExciter", "TrueClock", "TrueInstruments", "TrueState"]

Thing = Annotated[float, Number(1e-9, 1e12)]
Part = Annotated[float, Number(0.0, 1e9)]


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionExciter:
    """The document `exciter`: certified values, SI units.

    force_constant_U, parts_U : their expanded uncertainties (k = 2), relative
    band : frequency up to which the coil's current determines the force, Hz
    """

    force_constant: Thing
    band: Thing
    moving_mass: Thing
    body_mass: Thing
    flexure_stiffness: Thing
    isolation_stiffness: Thing
    stinger_stiffness: Thing
    flexure_damping_ratio: Part
    isolation_damping_ratio: Part
    stinger_damping: Part
    force_constant_U: Part
    parts_U: Part


@dataclass(frozen=True, slots=True)
class TrueState:
    """The true state of a channel.

    sensitivity : V per unit
    time_constant : s; None for DC
    gain : of the amplifier
    corner : of the AC coupling, Hz; None for DC
    skew : s
    """

    sensitivity: Thing
    time_constant: Annotated[float | None, Number(0.0, above=True)]
    gain: Thing
    corner: Annotated[float | None, Number(0.0)] = None
    skew: Annotated[float, Number(-1.0, 1.0)] = 0.0


@dataclass(frozen=True, slots=True)
class TrueInstruments:
    """The document `instruments` of the truth."""

    force: TrueState
    acceleration: TrueState


@dataclass(frozen=True, slots=True)
class TrueClock:
    """The document `clock` of the truth; error: relative."""

    error: Annotated[float, Number(-0.5, 0.5)]
