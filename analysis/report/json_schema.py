"""The shapes of report.json (schema rig/agreement/1) and comparison.json (rig/comparison/1), for readers that are not
ours: docs/report.md has the meanings.

SI units, energies in J per cycle. Null stands for what is not known. Further keys may be added under the same schema;
those that are required here stay.
"""

from collections.abc import Mapping
from typing import Any

from analysis.comparison import two_sessions as between
from analysis.comparison.whole_session import SCHEMA
from analysis.session.ledger_columns import TERMS
from daq.documents.json_schema import document_schema
from daq.documents.shapes import Each, Either, Keys, List, Null, Number, Shape, Text, YesNo

__all__ = ["COMPARED", "REPORT", "comparison_schema", "report_schema"]

VALUE, KNOWN = Number(), Number(null=True)
SHARE, SIZE = Number(0.0, 1.0), Number(0.0, null=True)
WORDS = List(Text())
JUDGED = Text(("holds", "does not hold", "undecided", "imposed"))


def _all(*parts: Mapping[str, Shape]) -> dict[str, Shape]:
    return {name: shape for part in parts for name, shape in part.items()}


def _each(names: str, shape: Shape) -> dict[str, Shape]:
    return dict.fromkeys(names.split(), shape)


RUN = Keys(
    _all(
        _each("run", Text()),
        _each("flags", WORDS),
        _each("order repeat", Number(0, whole=True)),
        _each("acceleration cycles clip_ratio", Number(0.0)),
        _each("W_exp W_exc W_kin W_phasor W_eq25", VALUE),
        _each("W_coil W_T_recorded", KNOWN),
    )
)
SOURCE = Keys({"source": Text(), "unit": Text(), "u": Number(0.0), "c": VALUE, "nu": SIZE, "share": Number(0.0)})
CONDITION = Keys(
    _all(
        _each("id material bed drive", Text()),
        _each("density diameter fill bed_mass frequency acceleration_set acceleration", SIZE),
        {"runs": List(RUN, 1), "uncertainty": List(SOURCE)},
        _each("U_W_exp k", Number(0.0)),
        _each("W_exp", VALUE),
        _each("nu s_W_exp U_W_T U_offset U_W_coil U_W_T_recorded U_offset_recorded W_detect force thd_box", SIZE),
        _each("W_net eta U_eta M_eff U_M_eff force_phase W_T W_f W_c W_T_paper bound exponent dKE_bed", KNOWN),
        _each("allowed_remainder", KNOWN),
        _each("offset E_n E_n_chain W_T_recorded offset_recorded E_n_recorded W_coil E_n_coil", KNOWN),
        _each("thd_force thd_acceleration", SIZE),
        {"period": SIZE, "periodic_share": Number(0.0, 1.0, null=True)},
        {"offset_terms": Keys(dict.fromkeys(TERMS, VALUE), null=True)},
    ),
    _each(
        "W_T_low W_T_high E_n_model refill_mean refill_skew refill_coverage refill_coverage_plain refills_needed", KNOWN
    )
    | {"varied": Each(Text()), "uncertainty_W_T": List(SOURCE)},
)
LINE = Keys(_each("slope U_slope intercept U_intercept", KNOWN) | _each("chi2 dof", VALUE), null=True)
COMPARISON = Keys(_all(_each("comparison against why", Text()), _each("n within", Number(0, whole=True))))
AGREEMENT = Keys(
    _all(
        {"n": Number(0, whole=True)},
        _each("ratio slope mean_offset put_in ratio_recorded", KNOWN),
        _each("U_ratio k nu U_slope U_ratio_recorded", SIZE),
    ),
    {"line": LINE},
)
CAUSE = Keys(
    _all(
        _each("cause law words note", Text()),
        {"in_run": YesNo(), "grows_with": Keys(_each("acceleration mass fill", KNOWN))},
        _each("share empty locked", KNOWN),
        {"over_first_principles": Keys(_each("low high", SIZE), null=True)},
        _each("empty_from locked_from", Text(("run", "computed"), null=True)),
    )
)
FINDING: dict[str, Shape] = {"found": Text(), "verdict": JUDGED, "why": Text(), "ties": WORDS}
CLAIM = Keys({"claim": Text(), "test": Text(), **FINDING, "cases": List(Keys({"at": Text(), **FINDING}))})
NULL = Keys(
    _all(
        {
            "null": Text(("locked", "carried", "loop-back")),
            "verdict": JUDGED,
            "why": Text(),
            "levels": Number(0, whole=True),
        },
        _each("bed_mass frequency", Number(0.0)),
        {"dphi": KNOWN},
        _each("U_dphi k nu", SIZE),
    ),
    {"gain": KNOWN, "U_gain": SIZE},
)
REFERENCE = Keys(
    _all({"verdict": JUDGED}, _each("reference of unit why", Text()), _each("value expected", KNOWN), {"U": SIZE})
)
FLAG = Keys({"flag": Text(), "worst": KNOWN, "runs": WORDS})
INSTRUMENT = Keys(
    _all(
        _each("channel model unit", Text()),
        _each("sensitivity calibration_U gain_tolerance noise_rms", VALUE),
        {"time_constant": SIZE},
    )
)
ASSUMED = Keys({"path": Text()}, {"value": Either(KNOWN, Text()), **_each("unit status source", Text(null=True))})
MISTAKE = Keys(
    _all(
        {"kind": Text(), "parameter": VALUE, **_each("what rule notice", Text())},
        {
            "conditions": List(
                Keys(_all({"id": Text(), "W_exp": VALUE}, _each("W_true eta error predicted ratio", KNOWN)))
            )
        },
    )
)
FIDELITY = Keys(
    {"tolerance": Number(0.0), "conditions": List(Keys({"id": Text(), "error": Number(0.0), "met": YesNo()}))}
)

PHASORS = List(List(VALUE, least=2))
WAVEFORMS = Keys(
    _all(
        {"condition": Text(), "run": Text(), "frequency": VALUE, "force": PHASORS, "acceleration": PHASORS},
        {"thd_force": KNOWN, "thd_acceleration": KNOWN},
        {"runs": List(Keys({"run": Text(), "W_cycles": List(VALUE, least=1)}))},
    ),
    {"cycles_each": Number(1, whole=True)},
)

REPORT = Keys(
    _all(
        {"schema": Text((SCHEMA,)), "protocol": Text(), "question": Text(), "synthetic": YesNo()},
        {"tests": Text(("chain", "model")), "waveform": Text(("ideal", "measured"))},
        {"conditions": List(CONDITION), "agreement": AGREEMENT, "causes": List(CAUSE), "claims": List(CLAIM)},
        {"nulls": List(NULL), "references": List(REFERENCE), "ledger": Keys({"closure_max": SIZE})},
        {"chain": Keys({"share": Number(0.0, 1.0, null=True), "needed": SHARE})},
        {"verdict": Text(("passes", "fails")), "reasons": WORDS, "flags": List(FLAG)},
        {"left_out": List(Keys(_each("run why", Text()))), "instruments": List(INSTRUMENT), "assumed": List(ASSUMED)},
    ),
    {
        "comparisons": List(COMPARISON),
        "fidelity": FIDELITY,
        "mistake": MISTAKE,
        "failures": WORDS,
        "support": WORDS,
        "waveforms": Either(Null(), WAVEFORMS),
        "resolved": Keys({}, {"protocol": Text(), "rig": Text()}),
    },
)

SESSION = Keys(
    _all(
        {"name": Text(), "protocol": Text(), "synthetic": YesNo(), "verdict": Text(("passes", "fails"))},
        {"beds": WORDS, "drives": WORDS, "conditions": Number(0, whole=True), "ratio": KNOWN, "U_ratio": SIZE},
    )
)
PAIR = Keys(
    _all(
        _each("A B material bed_A bed_B", Text()),
        _each("density diameter fill frequency acceleration_set acceleration_A acceleration_B U_relative", SIZE),
        _each("W_A W_B difference", VALUE),
        _each("U_A U_B U_difference", Number(0.0)),
        _each("E_n relative", KNOWN),
        _each("p p_holm", SHARE),
        {"significant": YesNo(), "not_compared": WORDS},
        _each("runs_A runs_B", Number(1, whole=True)),
    )
)
OVERALL = Keys(
    {"relative": VALUE, "U": Number(0.0), "k": Number(0.0), "nu": SIZE, "n": Number(1, whole=True)}, null=True
)
TAU = Number(-1.0, 1.0, null=True)
RANKS = Keys(
    _all(
        _each("n orders opposite", Number(0, whole=True)),
        {"tau": TAU, "interval": Either(Null(), List(TAU, 2, 2)), "decided_opposite": WORDS},
    )
)
COMPARED = Keys(
    _all(
        {"schema": Text((between.SCHEMA,)), "sessions": List(SESSION, 2, 2), "matched_by": WORDS},
        {"same_instruments": YesNo(), "pairs": List(PAIR), "overall": OVERALL, "ranks": RANKS},
        {"alone": List(Keys({"session": Text(("A", "B")), **_each("id why", Text())}))},
    )
)


def comparison_schema() -> Mapping[str, Any]:
    """The JSON Schema of comparison.json."""
    return document_schema(COMPARED, f"Two sessions compared, {between.SCHEMA}")


def report_schema() -> Mapping[str, Any]:
    """The JSON Schema of report.json."""
    return document_schema(REPORT, f"Agreement report, {SCHEMA}")
