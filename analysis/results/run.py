"""The energies of one run."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from analysis.energy.energy_and_phasors import AtBox, Energy
from analysis.uncertainty.budget_line import Line

__all__ = ["Coil", "RunEnergy"]


@dataclass(frozen=True, eq=False)
class Coil:
    """Energy at the gauge plane from the coil's current.

    W : J per cycle
    lines : its budget, except acceleration and scatter
    u_noise : standard uncertainty from the current's noise, J
    """

    W: float
    lines: tuple[Line, ...]
    u_noise: float


@dataclass(frozen=True, eq=False)
class RunEnergy:
    """Energies of one run.

    flags : names of quality bits in the window and of exceeded limits
    u_noise : standard deviation of W from the instruments' noise, J per cycle
    ledger : true energies, means over the same cycles, J per cycle (simulated sessions only); its
        `closure` is the largest relative error of the account
    use : utilisation of the exciter's limits (1: at the limit)
    coil : energy from the coil's current; None where it is not recorded
    at_box : the run corrected to the box; None where the stinger is not known
    recorded : W_T predicted on the waveform of this run, J per cycle; None where it was not
        computed
    u_recorded : standard uncertainty of `recorded` from the unknown history of the bed
    clip_ratio : fraction of samples at a rail, of the channel with most
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
