"""Deliberate errors: one well-known error of measurement practice at a time, so that its effect on
the report can be studied.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Annotated

from rig.units import Quantity

AC_CORNER = 0.5
"""Corner frequency, Hz, of the force channel's AC coupling in the error `corners`, which the channel
table does not state.
"""


@dataclass(frozen=True)
class DeliberateError:
    """At most one deliberate error of the measurement; none by default. The channel table and the
    predictions do not state it. `pole`: ratio of the accelerometer's actual time constant to the
    certified one. `corners`: both channels are AC coupled at 0.5 Hz, and the corner of the
    acceleration channel is higher by this fraction. `cycles`: number of cycles that W is read over,
    whole or not. `skew`: delay of the acceleration channel, samples. `clock`: ppm by which the
    clock of the acceleration channel runs fast. `coil`: the force is taken from the coil's current,
    BL i, instead of the gauge. `offset`: DC at the acceleration input as a fraction of the set
    level; velocity is then integrated without subtracting the mean. `friction`: the loss of the
    guide is counted as the bed's.
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
        """Return the names of the errors that are made, in the order of the fields."""
        made = ((item.name, getattr(self, item.name)) for item in fields(self))
        return tuple(name for name, value in made if value is not None and value is not False)

    @property
    def kind(self) -> str | None:
        """Return the name of the error that is made, None for none."""
        return next(iter(self.kinds), None)


NO_DELIBERATE_ERROR = DeliberateError()
