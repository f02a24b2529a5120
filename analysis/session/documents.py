"""What the analysis asks of the documents in a session, and the check: anybody may have written them."""

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from analysis.session.record import AnalysisError
from analysis.session.setting import CONDITION
from daq.documents.shapes import Each, Either, Keys, List, Number, Shape, Text, YesNo, deviations

if TYPE_CHECKING:
    from daq.session.record import Record

__all__ = ["DOCUMENTS", "TRUTHS", "checked", "deviations_of", "session_document_deviations", "truth_checked"]

ENERGIES = List(Number(), least=1)
WORDS = List(Text())
EXTRA = ("W_T_paper", "bound", "period", "periodic_share")
PREDICTION = Keys({
    "conditions": Each(Keys(
        {"acceleration": List(Number(0.0, above=True), least=1), "W_T": ENERGIES},
        {"W_f": ENERGIES, "W_c": ENERGIES, "model": List(Number(0.0, 1e6)), "refills": List(Number(0.0, 1e6)),
         **dict.fromkeys(("u_rel", "u_levels", "u_settling"), Number(0.0, 1e3, null=True)),
         **{name: Either(Number(null=True), List(Number())) for name in EXTRA}},
        as_long=("acceleration", "W_T", "W_f", "W_c"),
    )),
})  # fmt: skip
KINDS = ("optimum", "order", "rise", "fall", "nonlinear", "nearly_zero", "offset_within")
LIMITS = {"nonlinear": 1, "nearly_zero": 1, "offset_within": 2}
VALUES = {"nearly_zero": 2, "rise": 2, "fall": 2}
LEVEL = Keys({"value": Text(), "conditions": WORDS})
EXPECT = List(Keys({
    "claim": Text(), "kind": Text(KINDS), "about": Text(), "over": Text(), "values": WORDS, "limits": List(Number()),
    "imposed": Text(), "cases": List(Keys({"at": Each(Text()), "levels": List(LEVEL)})),
}))  # fmt: skip
VALUE = Keys({"path": Text()}, {name: Text(null=True) for name in ("unit", "status", "source")})
THING, SHARE = Number(1e-9, 1e12), Number(0.0, 1e9)
INSTRUMENT = Keys(
    {"sensitivity": THING, "time_constant": Number(0.0, above=True, null=True), "gain": THING},
    {"corner": Number(0.0, null=True), "skew": Number(-1.0, 1.0)},
)

SOME = Number(null=True)
COUNTS = Keys(dict.fromkeys(("auto", "written", "resolved"), SOME), {"planning": SOME})
_CHOICE: dict[str, Shape] = {"id": Text(), "met": YesNo(), "why": Text(null=True), "skipped": List(Text())}
_CHOICE |= dict.fromkeys(("rows", "settle", "record", "error", "error_rows", "error_window", "error_noise"), SOME)
_CHOICE |= dict.fromkeys(("written", "resolved"), List(SOME, least=3, most=3))
FIDELITY = Keys({
    "tolerance": Number(1e-9, 1e9), "rows_share": Number(), "cycles": COUNTS, "row_cycles": COUNTS,
    "not_met": List(Text()), "conditions": List(Keys(_CHOICE)),
})  # fmt: skip
EXCITER = Keys(
    dict.fromkeys(("force_constant", "band", "moving_mass", "body_mass"), THING)
    | dict.fromkeys(("flexure_stiffness", "isolation_stiffness", "stinger_stiffness"), THING)
    | dict.fromkeys(("flexure_damping_ratio", "isolation_damping_ratio", "stinger_damping"), SHARE)
    | dict.fromkeys(("force_constant_U", "parts_U"), SHARE)
)

DOCUMENTS: Mapping[str, Shape] = {
    "conditions": List(CONDITION),
    "prediction": PREDICTION,
    "protocol": Keys({}, {"name": Text(), "question": Text(), "expect": EXPECT}),
    "rig": Keys({}, {"name": Text(), "values": List(VALUE)}),
    "exciter": EXCITER,
    "fidelity": FIDELITY,
    "provenance": Keys({}),
}
"""The session's documents by name (docs/session-format.md). Others are free, and so are further keys in these."""

TRUTHS: Mapping[str, Shape] = {
    "instruments": Keys({"force": INSTRUMENT, "acceleration": INSTRUMENT}),
    "clock": Keys({"error": Number(-0.5, 0.5)}),
}
"""The documents of `session/truth`."""


def deviations_of(name: str, value: Any) -> Iterator[str]:
    """What is wrong with a document of the session (None: there is none, which is right)."""
    if value is None or name not in DOCUMENTS:
        return
    sentences = list(deviations(value, DOCUMENTS[name], name))
    yield from sentences
    if name == "protocol" and not sentences:
        yield from _claims(value.get("expect", []))


def checked(name: str, value: Any) -> Any:
    """A document of the session as it is. AnalysisError with its first deviation where it is not of its shape."""
    for sentence in deviations_of(name, value):
        raise AnalysisError(f"the session's document {sentence}")
    return value


def truth_checked(name: str, value: Any) -> Any:
    """A document of the truth as it is; AnalysisError as for `checked`."""
    for sentence in deviations(value, TRUTHS[name], f"truth/{name}") if value is not None else ():
        raise AnalysisError(f"the session's document {sentence}")
    return value


def session_document_deviations(record: "Record") -> Iterator[str]:
    """Every deviation in the documents of a session that the analysis reads; those that are no JSON are passed over."""
    for name in DOCUMENTS:
        yield from deviations_of(name, _readable(record.document, name))
    if record.truth is not None:
        for name, shape in TRUTHS.items():
            value = _readable(record.truth.document, name)
            yield from deviations(value, shape, f"truth/{name}") if value is not None else ()


def _readable(document: Callable[[str], Any], name: str) -> Any:
    from daq.session.plan import SessionError

    try:
        return document(name)
    except SessionError:
        return None


def _claims(claims: list[dict[str, Any]]) -> Iterator[str]:
    """Each kind of claim has so many limits and names at least so many values."""
    for position, claim in enumerate(claims):
        kind, place = claim["kind"], f"protocol.expect[{position}]"
        if len(claim["limits"]) != LIMITS.get(kind, len(claim["limits"])):
            yield f"{place}.limits has {len(claim['limits'])} numbers, expected {LIMITS[kind]}"
        if len(claim["values"]) < VALUES.get(kind, 0):
            yield f"{place}.values has {len(claim['values'])} values, expected {VALUES[kind]}"
