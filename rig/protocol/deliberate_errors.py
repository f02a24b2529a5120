"""Bad practice on purpose: one well-known error of a measurement, so that its report can be
studied.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Annotated

from rig.units import Quantity

AC_CORNER = 0.5
"""Corner of the force channel's AC coupling that nobody wrote down, Hz."""


@dataclass(frozen=True)
class DeliberateError:
    """At most one of these errors; none by default. The channel table and the predictions know
    nothing of it.

    pole : actual over certified time constant of the accelerometer corners : both channels are AC
    coupled at 0.5 Hz, the acceleration's corner by this fraction above the force's cycles : W is
    read over so many cycles, whole or not skew : samples by which the acceleration channel comes
    late clock : ppm by which the acceleration channel's own clock runs fast coil : the force is
    taken from the coil's current, BL i in place of the gauge offset : DC at the acceleration's
    input over the set level; the reading integrates without taking off any mean friction : what the
    guide takes is read as the bed's
    """

    pole: Annotated[float | None, Quantity("number", 0.0, 100.0, above=True)] = None
    corners: Annotated[float | None, Quantity("number", -0.9, 10.0)] = None
    cycles: Annotated[float | None, Quantity("cycles", 1.0, 60.0)] = None
    skew: Annotated[int | None, Quantity("samples", 1, 1000)] = None
    clock: Annotated[float | None, Quantity("ppm", 0.0, 1000.0, above=True)] = None
    coil: bool = False
    offset: Annotated[float | None, Quantity("number", -1.0, 1.0)] = None
    friction: bool = False

    @property
    def kinds(self) -> tuple[str, ...]:
        """Names of the errors that are made: one, or none."""
        made = ((item.name, getattr(self, item.name)) for item in fields(self))
        return tuple(name for name, value in made if value is not None and value is not False)

    @property
    def kind(self) -> str | None:
        """Name of the error that is made."""
        return next(iter(self.kinds), None)


NO_DELIBERATE_ERROR = DeliberateError()
