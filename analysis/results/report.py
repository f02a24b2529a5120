"""The report of a session, the source of every writer: its fields are the keys of report.json,
whose meanings are in docs/report.md.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from analysis.energy.sweep_curve import SweepCurve
from analysis.results.condition_row import ConditionRow
from analysis.results.deliberate_error_rows import DeliberateErrorReport
from analysis.results.judged_rows import ClaimRow, NullRow, ReferenceRow
from analysis.results.session_rows import AgreementRow, CauseRow, ComparisonRow
from analysis.results.waveform_rows import Waveforms
from analysis.session.fidelity import Fidelity
from analysis.session.protocol import RigValue
from analysis.session.record import AnalysisError
from daq.documents.classes import LEFT_OUT, DocumentError, from_document, to_document
from daq.documents.shapes import Number, Text

__all__ = [
    "SCHEMA",
    "FlagRow",
    "InstrumentRow",
    "LedgerCheck",
    "LeftOutRun",
    "MeasurementChain",
    "Report",
    "Resolved",
]

SCHEMA = "rig/agreement/2"
Size = Annotated[float | None, Number(0.0)]


@dataclass(frozen=True, slots=True)
class LedgerCheck:
    """The check of the rig's energy account; closure_max: its largest relative error, None without
    truth.
    """

    closure_max: Size


@dataclass(frozen=True, slots=True)
class MeasurementChain:
    """The chain comparison: fraction of the conditions in which W_exp agrees with the rig's own
    ledger, and the fraction needed.
    """

    share: Annotated[float | None, Number(0.0, 1.0)]
    needed: Annotated[float, Number(0.0, 1.0)]


@dataclass(frozen=True, slots=True)
class FlagRow:
    """A flag, the runs that carry it, and the largest utilisation of a limit (1: at the limit)."""

    flag: str
    worst: float | None
    runs: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class LeftOutRun:
    """A run that could not be used, and why."""

    run: str
    why: str


@dataclass(frozen=True, slots=True)
class InstrumentRow:
    """A channel's certified values. sensitivity: V per unit; time_constant: s, None for DC."""

    channel: str
    model: str
    unit: str
    sensitivity: float
    time_constant: Size
    calibration_U: float
    gain_tolerance: float
    noise_rms: float


@dataclass(frozen=True, slots=True)
class Resolved:
    """Protocol and rig file written out, from which the session can be repeated."""

    protocol: Annotated[str | None, LEFT_OUT] = None
    rig: Annotated[str | None, LEFT_OUT] = None

    def files(self) -> tuple[tuple[str, str], ...]:
        """Return the documents that are present, by name."""
        return tuple(to_document(self).items())


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """The report of a session: what was tested, the conditions, their agreement with W_T, the
    verdict.

    prediction : names of the predictions that W_T is of; None if not stated
    """

    schema: Annotated[str, Text((SCHEMA,))]
    protocol: str
    question: str
    synthetic: bool
    tests: Annotated[str, Text(("measurement", "model"))]
    waveform: Annotated[str, Text(("ideal", "measured"))]
    prediction: str | None = None
    support: tuple[str, ...] = ()
    conditions: tuple[ConditionRow, ...]
    agreement: AgreementRow
    comparisons: tuple[ComparisonRow, ...] = ()
    causes: tuple[CauseRow, ...]
    claims: tuple[ClaimRow, ...]
    nulls: tuple[NullRow, ...]
    references: tuple[ReferenceRow, ...]
    ledger: LedgerCheck
    chain: MeasurementChain
    verdict: Annotated[str, Text(("passes", "fails"))]
    reasons: tuple[str, ...]
    failures: tuple[str, ...] = ()
    flags: tuple[FlagRow, ...]
    waveforms: Waveforms | None = None
    left_out: tuple[LeftOutRun, ...]
    instruments: tuple[InstrumentRow, ...]
    assumed: tuple[RigValue, ...]
    sweeps: Annotated[tuple[SweepCurve, ...], LEFT_OUT] = ()
    resolved: Annotated[Resolved | None, LEFT_OUT] = None
    fidelity: Annotated[Fidelity | None, LEFT_OUT] = None
    deliberate_error: Annotated[DeliberateErrorReport | None, LEFT_OUT] = None

    @property
    def passes(self) -> bool:
        """Whether the session passes."""
        return self.verdict == "passes"

    def document(self) -> dict[str, Any]:
        """Return report.json as a plain dict."""
        return to_document(self)

    @classmethod
    def of(cls, document: Mapping[str, Any], name: str = "report.json") -> "Report":
        """Return the report that a report.json holds. AnalysisError with the first key that is
        missing or wrong.
        """
        try:
            return from_document(cls, document)
        except DocumentError as error:
            raise AnalysisError(f"{name}: {error}") from error
