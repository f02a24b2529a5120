"""What the analysis makes of one run."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from analysis.energy.energy_and_phasors import AtBox, Energy
from analysis.uncertainty.budget_line import Line

__all__ = ["Coil", "RunEnergy"]


@dataclass(frozen=True, eq=False)
class Coil:
    """W: J per cycle, work at the gauge plane as the coil's current tells it. lines: its budget
    beside acceleration and scatter. u_noise: J, from the current's noise."""

    W: float
    lines: tuple[Line, ...]
    u_noise: float


@dataclass(frozen=True, eq=False)
class RunEnergy:
    """Energies of one run.

    flags: names of quality bits in the window and of limits exceeded. u_noise: J per cycle,
    standard deviation of W from the instruments' noise. ledger: true energies in J per cycle, means
    over the same cycles (simulated sessions only); its `closure` is the largest relative error of
    the account. use: shares of the exciter's limits (1 = at it). coil: energy as the coil's current
    tells it, None where that is not recorded. at_box: the same run compensated for place and mass
    of the gauge, None where the stinger is not known. recorded: what is predicted on the waveform
    that this run recorded, J per cycle, None where it was not computed; u_recorded: its standard
    uncertainty from what the bed went through before. clip_ratio: share of samples at a rail, of
    the channel that has most.
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
    coil: Coil | None = None
    at_box: AtBox | None = None
    recorded: float | None = None
    u_recorded: float = 0.0
    clip_ratio: float = 0.0
