"""A condition in the report, with its runs and its uncertainty budget.

SI units, energies in J per cycle, None for unknown values; docs/report.md has the meanings.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Annotated

from daq.documents.classes import LEFT_OUT, AtLeast
from daq.documents.shapes import Number, Text

__all__ = ["TERMS", "ConditionRow", "OffsetTerms", "RunRow", "SourceRow"]

AtLeastZero = Annotated[float, Number(0.0)]
Size = Annotated[float | None, Number(0.0)]
"""A number from 0 on; None: not known."""
Share = Annotated[float | None, Number(0.0, 1.0)]
Place = Annotated[str | None, Text(), LEFT_OUT]
Known = Annotated[float | None, Number(), LEFT_OUT]


@dataclass(frozen=True, slots=True)
class SourceRow:
    """A line of an uncertainty budget.

    u : standard uncertainty, in `unit`
    c : sensitivity, J per unit
    nu : degrees of freedom; None: without bound
    share : fraction of the total u^2
    """

    source: str
    unit: str
    u: AtLeastZero
    c: float
    nu: Size
    share: AtLeastZero


@dataclass(frozen=True, slots=True)
class RunRow:
    """Energies of one run."""

    run: str
    order: Annotated[int, Number(0, whole=True)]
    repeat: Annotated[int, Number(0, whole=True)]
    acceleration: AtLeastZero
    W_exp: float
    W_exc: float
    W_kin: float
    W_phasor: float
    W_eq25: float
    W_coil: float | None
    W_T_recorded: float | None
    cycles: AtLeastZero
    flags: tuple[str, ...]
    clip_ratio: AtLeastZero


@dataclass(frozen=True, slots=True)
class OffsetTerms:
    """The terms of an offset, fractions of W_T, which add up to it.

    Of single runs (`analysis.comparison.offset_terms`) the same in J per cycle.
    """

    noise: float
    air: float
    gas: float
    mount: float
    waveform: float
    phase: float
    scale: float
    refill: float
    remainder: float

    def named(self) -> tuple[tuple[str, float], ...]:
        """Return the terms with their names."""
        return tuple((name, getattr(self, name)) for name in TERMS)


TERMS = tuple(each.name for each in fields(OffsetTerms))
"""Names of the terms of an offset."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionRow:
    """An entry of `conditions` in report.json."""

    id: str
    material: str
    density: Size
    diameter: Size
    fill: Size
    bed: str
    drive: str
    bed_mass: Size
    frequency: Size
    acceleration_set: Size
    acceleration: Size
    period: Size
    periodic_share: Share
    dKE_bed: float | None
    runs: Annotated[tuple[RunRow, ...], AtLeast(1)]
    W_exp: float
    s_W_exp: Size
    U_W_exp: AtLeastZero
    k: AtLeastZero
    nu: Size
    W_net: float | None
    W_detect: Size
    eta: float | None
    U_eta: float | None
    M_eff: float | None
    U_M_eff: float | None
    force: Size
    force_phase: float | None
    thd_force: Size
    thd_acceleration: Size
    thd_box: Size
    W_T: float | None
    U_W_T: Size
    W_f: float | None
    W_c: float | None
    W_T_as_printed: float | None
    U_W_T_as_printed: Size = None
    W_T_layers: float | None = None
    U_W_T_layers: Size = None
    W_T_column: float | None = None
    U_W_T_column: Size = None
    prediction: str | None = None
    inside: bool | None = None
    reasons: Mapping[str, str] = field(default_factory=dict)
    bound: float | None
    exponent: float | None
    offset: float | None
    U_offset: Size
    E_n: float | None
    E_n_truth: float | None
    W_T_low: float | None = None
    W_T_high: float | None = None
    E_n_model: float | None = None
    refill_mean: float | None = None
    refill_skew: float | None = None
    refill_coverage: float | None = None
    refill_coverage_plain: float | None = None
    refills_needed: Annotated[int | None, Number()] = None
    W_T_recorded: float | None
    U_W_T_recorded: Size
    offset_recorded: float | None
    U_offset_recorded: Size
    E_n_recorded: float | None
    W_coil: float | None
    U_W_coil: Size
    E_n_coil: float | None
    gauge: Place = None
    accelerometer: Place = None
    W_at_box: Known = None
    M_eff_at_box: Known = None
    uncertainty: tuple[SourceRow, ...]
    uncertainty_W_T: tuple[SourceRow, ...] = ()
    offset_terms: OffsetTerms | None
    allowed_remainder: float | None
    varied: Mapping[str, str] = field(default_factory=dict)

    @property
    def detected(self) -> float:
        """W_detect; 0 where it is not known."""
        return self.W_detect or 0.0
