"""Schemas of the JSON documents in a session, and their validation.

Documents are validated before use, because other software may have written them.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from analysis.session.exciter import SessionExciter, TrueClock, TrueInstruments
from analysis.session.fidelity import Fidelity
from analysis.session.former_names import prediction_today, protocol_today, rig_today
from analysis.session.prediction_entry import PREDICTION
from analysis.session.protocol import ExpectedClaim, SessionProtocol, SessionRig
from analysis.session.record import AnalysisError, Truth
from analysis.session.setting import CONDITION
from daq.documents.classes import built, shape_of
from daq.documents.shapes import Keys, List, Shape, deviations

if TYPE_CHECKING:
    from daq.session.record import Record

__all__ = [
    "DOCUMENTS",
    "TRUTHS",
    "checked",
    "deviations_of",
    "document_as",
    "session_document_deviations",
    "truth_as",
]

T = TypeVar("T")

# Of each kind of claim the number of limits, and the least number of values.
LIMITS = {"nonlinear": 1, "nearly_zero": 1, "offset_within": 2}
VALUES = {"nearly_zero": 2, "rise": 2, "fall": 2}

DOCUMENTS: Mapping[str, Shape] = {
    "conditions": List(CONDITION),
    "prediction": PREDICTION,
    "protocol": shape_of(SessionProtocol),
    "rig": shape_of(SessionRig),
    "exciter": shape_of(SessionExciter),
    "fidelity": shape_of(Fidelity),
    "provenance": Keys({}),
}
"""Schemas of the session's documents by name (docs/session-format.md). Other documents may be
there, and further keys in these.
"""

TRUTHS: Mapping[str, Shape] = {
    "instruments": shape_of(TrueInstruments),
    "clock": shape_of(TrueClock),
}
"""Schemas of the documents of `session/truth`."""


def deviations_of(name: str, value: Any) -> Iterator[str]:
    """Yield the deviations of a session's document from its schema; none for a missing document
    (None).
    """
    if value is None or name not in DOCUMENTS:
        return
    value = today(name, value)
    sentences = list(deviations(value, DOCUMENTS[name], name))
    yield from sentences
    if name == "protocol" and not sentences:
        yield from _claims(built(SessionProtocol, value).expect)


def today(name: str, value: Any) -> Any:
    """Return a document of the session with today's names."""
    translated = {"prediction": prediction_today, "protocol": protocol_today, "rig": rig_today}
    return translated[name](value) if name in translated else value


def checked(name: str, value: Any) -> Any:
    """Return a document of the session unchanged. AnalysisError with its first deviation where it
    has any.
    """
    for sentence in deviations_of(name, value):
        raise AnalysisError(f"the session's document {sentence}")
    return value


def document_as(cls: type[T], name: str, value: Any) -> T | None:
    """Return a document of the session as a value of its class; None where there is none.
    AnalysisError as for `checked`.
    """
    return None if checked(name, value) is None else built(cls, today(name, value))


def truth_as(cls: type[T], name: str, truth: Truth) -> T | None:
    """Return a document of the truth as a value of its class; None where there is none.
    AnalysisError as for `checked`.
    """
    value = truth.document(name)
    for sentence in deviations(value, TRUTHS[name], f"truth/{name}") if value is not None else ():
        raise AnalysisError(f"the session's document {sentence}")
    return None if value is None else built(cls, value)


def session_document_deviations(record: "Record") -> Iterator[str]:
    """Yield every deviation in the documents of a session that the analysis reads; documents that
    are no JSON are skipped.
    """
    for name in DOCUMENTS:
        yield from deviations_of(name, _readable(record.document, name))
    if record.truth is not None:
        for name, shape in TRUTHS.items():
            value = _readable(record.truth.document, name)
            yield from deviations(value, shape, f"truth/{name}") if value is not None else ()


def _readable(document: Callable[[str], Any], name: str) -> Any:
    """Return a document; None where it is missing or no JSON."""
    from daq.session.plan import SessionError

    try:
        return document(name)
    except SessionError:
        return None


def _claims(claims: Sequence[ExpectedClaim]) -> Iterator[str]:
    """Yield the claims that have too few values or the wrong number of limits for their kind."""
    for position, claim in enumerate(claims):
        kind, place = claim.kind, f"protocol.expect[{position}]"
        if len(claim.limits) != LIMITS.get(kind, len(claim.limits)):
            yield f"{place}.limits has {len(claim.limits)} numbers, expected {LIMITS[kind]}"
        if len(claim.values) < VALUES.get(kind, 0):
            yield f"{place}.values has {len(claim.values)} values, expected {VALUES[kind]}"
