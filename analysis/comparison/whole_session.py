"""Agreement between measured and predicted dissipation: the report as a plain dict (interfaces.md, report.json)."""

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from analysis.comparison.causes import causes
from analysis.comparison.claims import judge
from analysis.comparison.family_of_tests import CHAIN_SHARE, chain_tests, critical_score, sign_tests
from analysis.comparison.loop_back import LoopBack, loop_back_nulls
from analysis.comparison.null_tests import null_tests
from analysis.comparison.offset_terms import Actual, allowed_remainder, offset_terms
from analysis.comparison.pooled_ratio import energy_ratio, line_through, propagated, recorded_ratio
from analysis.comparison.references import references, signs
from analysis.comparison.refills import refills_row
from analysis.comparison.three_comparisons import comparisons, model_row
from analysis.comparison.verdict import verdict
from analysis.results.condition import Result, box_distortion, evaluate
from analysis.results.deliberate_errors import deliberate
from analysis.results.mean_cycle import waveforms
from analysis.results.predicted_on_record import Recorded
from analysis.results.run import RunEnergy
from analysis.session.record import ChannelFacts
from analysis.session.setting import Setting
from analysis.uncertainty.budget_line import Line
from analysis.uncertainty.estimate import Estimate

__all__ = ["agreement"]

SCHEMA = "rig/agreement/1"
NAMED = ("id", "material", "density", "diameter", "fill", "bed", "drive", "bed_mass")
BOX_LOSSES = ("W_noise", "W_air", "W_gas", "W_mount")  # ledger columns of what is not in the bed
OWN_MECHANISM = {"grains"}  # beds that do not share the mechanism behind W_T


def agreement(
    runs: Iterable[RunEnergy],
    conditions: Mapping[str, Mapping[str, Any]],
    prediction: Mapping[str, Any] | None,
    channels: Mapping[str, ChannelFacts],
    *,
    protocol: str = "",
    question: str = "",
    synthetic: bool = False,
    assumed: Sequence[Mapping[str, Any]] = (),
    left_out: Sequence[Mapping[str, str]] = (),
    expect: Iterable[Mapping[str, Any]] = (),
    actual: Actual | None = None,
    fidelity: Mapping[str, Any] | None = None,
    resolved: Mapping[str, str] | None = None,
    loop_backs: Sequence[LoopBack] = (),
    sweeps: Sequence[Mapping[str, Any]] = (),
) -> dict[str, Any]:
    """The report of a session.

    runs: energies of its runs. conditions: by id, in the order to report. prediction: {"conditions": {id:
    {"acceleration": [m/s^2], "W_T": [J], "W_f": [J], "W_c": [J], "u_rel", "u_levels", "u_settling", "refills":
    [energies of poured beds over W_T], "W_T_paper", "bound", "period", "periodic_share"}}}, None for none: plain
    numbers, so that a laboratory's own can take its place.
    channels: channel table with "force" and "acceleration". assumed: values of the rig file (path, value, unit, status,
    source). left_out: runs that could not be used, with the reason. expect: claims to judge
    (analysis.comparison.claims.judge). actual: the instruments as they really are, for the terms of the offset
    (simulated sessions only). fidelity: how finely and how long each condition was simulated, where that was chosen and
    not written, as the session says. resolved: protocol and rig file written out, with which the session can be
    repeated. loop_backs: what runs with one voltage at both inputs tell. sweeps: of runs that sweep
    (analysis.energy.sweep), which state no energy.

    Numbers in SI, energies in J per cycle; None for what is not known, and for degrees of freedom without bound.
    """
    settings = {name: Setting.of(condition) for name, condition in conditions.items()}
    grouped: dict[str, list[RunEnergy]] = defaultdict(list)
    for run in runs:
        grouped[run.condition].append(run)
    entries = (prediction or {}).get("conditions", {})
    results = [
        evaluate(setting, grouped[name], entries.get(name), channels)
        for name, setting in settings.items()
        if grouped[name]
    ]
    empties = {_level(r.setting): r for r in results if r.setting.is_empty}
    nulls = null_tests(settings, grouped, channels) + loop_back_nulls(loop_backs, channels)
    ledger = {"closure_max": _closure(results)}
    known = references(results, channels)
    tests = [test for null in nulls for test in null.tested]
    tests += [test for reference in known for test in reference.tested]
    limit = critical_score([*tests, *sign_tests(results)], chain_tests(results))
    nulls = tuple(null.judged(limit) for null in nulls)
    known = tuple(reference.judged(limit) for reference in known)
    known = (signs(results, limit), *known) if results else ()
    judged = verdict(results, nulls, known, ledger["closure_max"], left_out, sweeps, limit)
    seen = [r.setting for r in results] + [settings[one["condition"]] for one in sweeps]
    ideal = synthetic and all(setting.drive == "servo" for setting in seen)
    report = {
        "schema": SCHEMA,
        "protocol": protocol,
        "question": question,
        "synthetic": synthetic,
        "tests": "chain" if synthetic and not OWN_MECHANISM & {s.bed for s in seen} else "model",
        "waveform": "ideal" if ideal else "measured",
        "support": sorted({str(c["support"]) for c in conditions.values() if c.get("support")}),
        "conditions": [
            _row(result, empties)
            | {
                "offset_terms": offset_terms(result, entries.get(result.setting.id), channels, actual),
                "allowed_remainder": allowed_remainder(result),
                "varied": _varied(conditions[result.setting.id]),
            }
            for result in results
        ],
        "agreement": _agreement(results),
        "comparisons": comparisons(results),
        "causes": causes(results, conditions, channels, assumed),
        "claims": judge(expect, {result.setting.id: result for result in results}),
        "nulls": [null.row() for null in nulls],
        "references": [reference.row() for reference in known],
        "ledger": ledger,
        "chain": {"share": judged.chain_share, "needed": CHAIN_SHARE},
        "verdict": judged.verdict,
        "reasons": list(judged.reasons),
        "failures": list(judged.failures),
        "flags": _flags(results, sweeps) + (_too_coarse(results, fidelity) if fidelity else []),
        "waveforms": waveforms(results),
        "left_out": [dict(entry) for entry in left_out],
        "instruments": [_instrument(channel) for channel in channels.values()],
        "assumed": [dict(value) for value in assumed],
    }
    if sweeps:
        report["sweeps"] = [dict(one) for one in sweeps]
    if resolved:
        report["resolved"] = dict(resolved)
    if fidelity is not None:
        report["fidelity"] = dict(fidelity)
    mistake = deliberate(results, channels)
    if mistake is not None:
        report["mistake"] = mistake
    return {key: _jsonable(value) for key, value in report.items()}


def _varied(condition: Mapping[str, Any]) -> dict[str, str]:
    """What the protocol varied beside the settings that every condition has; nothing where the session does not say."""
    found = condition.get("varied")
    return {str(name): str(text) for name, text in found.items()} if isinstance(found, Mapping) else {}


def _level(setting: Setting) -> tuple[Any, ...]:
    """What a condition shares with the empty box that it is compared with."""
    return setting.drive, setting.frequency, setting.acceleration_set, *setting.places


def _row(result: Result, empties: Mapping[tuple[Any, ...], Result]) -> dict[str, Any]:
    setting, exp, got = result.setting, result.W_exp, result.predicted
    empty = empties.get(_level(setting))
    W = [run.energy.W for run in result.runs]
    n = len(W)
    distortions = [d for d in (box_distortion(run, setting) for run in result.runs) if d is not None]
    told = result.W_T is not None and result.comparable
    offset = _offset(result, exp.value, result.W_T) if told else None
    difference = result.difference if told else None
    return {
        **{name: getattr(setting, name) for name in NAMED},
        "frequency": setting.frequency, "acceleration_set": setting.acceleration_set,
        "acceleration": result.mean("level"), "period": got.get("period"), "periodic_share": got.get("periodic_share"),
        "dKE_bed": _ledger_mean(result, "dKE_bed"),
        "runs": [_run_row(run) for run in result.runs],
        "W_exp": exp.value,
        "s_W_exp": math.sqrt(math.fsum((w - exp.value) ** 2 for w in W) / (n - 1)) if n > 1 else None,
        "U_W_exp": exp.U, "k": exp.k, "nu": exp.nu,
        "W_net": None if empty is None else exp.value - empty.W_exp.value,
        "W_detect": result.detect, "eta": result.loss.value, "U_eta": result.loss.U,
        "M_eff": result.mass.value, "U_M_eff": result.mass.U,
        "force": result.mean("force_level"), "force_phase": result.mean("force_phase"),
        "thd_force": result.mean("thd_force"), "thd_acceleration": result.mean("thd_acceleration"),
        "thd_box": math.fsum(distortions) / n if len(distortions) == n else None,
        "W_T": got.get("W_T"), "U_W_T": result.W_T.U if result.W_T else None,
        **{name: got.get(name) for name in ("W_f", "W_c", "W_T_paper", "bound", "exponent")},
        "offset": offset.value if offset else None, "U_offset": offset.U if offset else None,
        "E_n": _E_n(difference), "E_n_chain": _E_n(result.chain),
        **model_row(result), **refills_row(result), **_recorded(result),
        "W_coil": result.coil.value if result.coil else None, "U_W_coil": result.coil.U if result.coil else None,
        "E_n_coil": _E_n(result.coil_apart),
        **_at_box(result),
        "uncertainty": [_budget_row(line, line.c, line.part, exp.u) for line in result.lines if line.c],
        "uncertainty_W_T": [
            _budget_row(line, line.c_T, line.part_T, result.W_T.u) for line in result.lines if result.W_T and line.c_T
        ],
    }  # fmt: skip


def _budget_row(line: Line, sensitivity: float, part: float, u: float) -> dict[str, Any]:
    """A line of the budget of W_exp or W_T, whose standard uncertainty is u (J): its part of u^2 is `share`."""
    return {"source": line.source, "unit": line.unit, "u": line.u, "c": sensitivity, "nu": line.nu,
            "share": (part / u) ** 2 if u else 0.0}  # fmt: skip


def _at_box(result: Result) -> dict[str, Any]:
    """Places of gauge and accelerometer with the means compensated for them; nothing where they are not known."""
    found = [run.at_box for run in result.runs if run.at_box is not None]
    if len(found) < len(result.runs):
        return {}
    return {
        "gauge": result.setting.gauge, "accelerometer": result.setting.accelerometer,
        "W_at_box": math.fsum(one.W for one in found) / len(found),
        "M_eff_at_box": math.fsum(one.M_eff for one in found) / len(found),
    }  # fmt: skip


def _recorded(result: Result) -> dict[str, Any]:
    """The comparison with W_T on the recorded waveforms; the offset as `offset` is left out where nothing is told."""
    names = ("W_T_recorded", "U_W_T_recorded", "offset_recorded", "U_offset_recorded", "E_n_recorded")
    found = result.recorded
    if found is None:
        return dict.fromkeys(names)
    scale = found.W_T.value
    offset = _offset(found, result.W_exp.value, found.W_T) if result.comparable_recorded else None
    of_W = (offset.value, offset.U) if offset else (None, None)
    return dict(zip(names, (scale, found.W_T.U, *of_W, _E_n(found.difference)), strict=True))


def _offset(source: Result | Recorded, W: float, W_T: Estimate | None) -> Estimate | None:
    """W/W_T - 1 with the budget behind both: an error of W_T weighs W/W_T times as much as one of W."""
    if W_T is None:
        return None
    return propagated(W / W_T.value - 1, [(source, 1 / W_T.value, -W / W_T.value**2)])


def _run_row(run: RunEnergy) -> dict[str, Any]:
    energy = run.energy
    return {
        "run": run.run, "order": run.order, "repeat": run.repeat, "acceleration": energy.level,
        "W_exp": energy.W, "W_exc": energy.W_exc, "W_kin": energy.W_kin, "W_phasor": energy.W_phasor,
        "W_eq25": energy.W_eq25, "W_coil": run.coil.W if run.coil else None,
        "W_T_recorded": run.recorded,
        "cycles": energy.cycles, "flags": list(run.flags), "clip_ratio": run.clip_ratio,
    }  # fmt: skip


def _agreement(results: Sequence[Result]) -> dict[str, Any]:
    """Energy-weighted ratio, lines through W_exp against W_T, mean offset; common errors stay common."""
    comparable = [r for r in results if r.comparable]
    ratio = energy_ratio(comparable)
    on_waveform = [(r, r.recorded.W_T) for r in results if r.recorded is not None and r.comparable_recorded]
    recorded = recorded_ratio([r for r, _ in on_waveform])
    predicted = [(r, r.W_T) for r in results if r.W_T is not None and r.W_T.value > 0]
    on_record = {
        "ratio_recorded": recorded.value if recorded else None, "U_ratio_recorded": recorded.U if recorded else None,
        "put_in_recorded": _put_in(on_waveform),
    }  # fmt: skip
    if ratio is None:
        names = ("ratio", "U_ratio", "k", "nu", "slope", "U_slope", "line", "mean_offset")
        return dict.fromkeys(names, None) | {"n": 0, "put_in": _put_in(predicted)} | on_record
    offsets = [r.W_exp.value / r.W_T.value - 1 for r in comparable if r.W_T is not None]
    slope, line = line_through(comparable, origin=True), line_through(comparable)
    known = line or slope  # of two conditions there is only the line through the origin
    if known is not None and not known.is_likely:
        slope = None  # W_exp is no straight line over W_T: a slope would state a U that it has not
    return {
        "ratio": ratio.value, "U_ratio": ratio.U, "k": ratio.k, "nu": ratio.nu,
        "slope": slope.slope.value if slope else None, "U_slope": slope.slope.U if slope else None,
        "line": line.row() if line else None,
        "mean_offset": math.fsum(offsets) / len(offsets) if offsets else None, "n": len(offsets),
        "put_in": _put_in([(r, W_T) for r, W_T in predicted if r.comparable]), **on_record,
    }  # fmt: skip


def _put_in(predicted: Sequence[tuple[Result, Estimate]]) -> float | None:
    """Losses that the rig file adds to the bed's, as a fraction of the predicted energy; None without truth or W_T."""
    total = math.fsum(W_T.value for _, W_T in predicted)
    found = [_ledger_mean(result, column) for result, _ in predicted for column in BOX_LOSSES]
    known = [value for value in found if value is not None]
    return math.fsum(known) / total if known and total > 0 else None


def _E_n(difference: Estimate | None) -> float | None:
    """E_n score: the difference over its expanded uncertainty."""
    return None if difference is None or not difference.U else difference.value / difference.U


def _ledger_mean(result: Result, column: str) -> float | None:
    values = [run.ledger[column] for run in result.runs if run.ledger is not None and column in run.ledger]
    return math.fsum(values) / len(values) if len(values) == len(result.runs) else None


def _closure(results: Sequence[Result]) -> float | None:
    ledgers = [run.ledger for result in results for run in result.runs if run.ledger is not None]
    return max((ledger["closure"] for ledger in ledgers if "closure" in ledger), default=None)


def _flags(results: Sequence[Result], sweeps: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Every flag with the runs that carry it, in the order of first appearance, and the most used of a limit."""
    runs: dict[str, list[tuple[str, Mapping[str, float]]]] = defaultdict(list)
    every = [(run.run, run.flags, run.use) for result in results for run in result.runs]
    every += [(one["run"], one["flags"], one["use"]) for one in sweeps]
    for name, flags, use in every:
        for flag in flags:
            runs[flag].append((name, use))
    return [
        {
            "flag": flag,
            "worst": max((use[flag[5:]] for _, use in found if flag[5:] in use), default=None),
            "runs": [name for name, _ in found],
        }
        for flag, found in runs.items()
    ]


def _too_coarse(results: Sequence[Result], fidelity: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The flag of the conditions whose predicted error exceeds the tolerance that was asked for."""
    over = {row["id"]: row["error"] / fidelity["tolerance"] for row in fidelity["conditions"] if not row["met"]}
    runs = [run.run for result in results if result.setting.id in over for run in result.runs]
    return [{"flag": "over_tolerance", "worst": max(over.values()), "runs": runs}] if runs else []


def _instrument(channel: ChannelFacts) -> dict[str, Any]:
    return {
        "channel": channel.name, "model": channel.model, "unit": channel.unit, "sensitivity": channel.sensitivity,
        "time_constant": channel.time_constant, "calibration_U": channel.calibration_U,
        "gain_tolerance": channel.gain_tolerance, "noise_rms": channel.noise_rms,
    }  # fmt: skip


def _jsonable(value: Any) -> Any:
    """The same with null for every number that is not finite (JSON has none)."""
    if isinstance(value, dict):
        return {key: _jsonable(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_jsonable(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
