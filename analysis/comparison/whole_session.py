"""The report of a session: agreement between measured and predicted dissipation."""

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from analysis.comparison.causes import causes
from analysis.comparison.claims import judge
from analysis.comparison.family_of_tests import CHAIN_SHARE, chain_tests, critical_score, sign_tests
from analysis.comparison.loop_back import LoopBack, loop_back_nulls
from analysis.comparison.null_tests import null_tests
from analysis.comparison.offset_terms import Actual, allowed_remainder
from analysis.comparison.pooled_results import (
    agreement_row,
    comparisons,
    is_mechanism_shared,
    model_columns,
    predictions_named,
    propagated,
)
from analysis.comparison.references import references, signs
from analysis.comparison.verdict import verdict
from analysis.energy.sweep_curve import SweepCurve
from analysis.evaluations import Evaluated, evaluated
from analysis.results.condition import Result, box_distortion
from analysis.results.condition_row import ConditionRow, RunRow, SourceRow
from analysis.results.deliberate_errors import deliberate
from analysis.results.judged_rows import ClaimRow
from analysis.results.mean_cycle import waveforms
from analysis.results.recorded_waveform import Recorded
from analysis.results.report import (
    SCHEMA,
    FlagRow,
    InstrumentRow,
    LedgerCheck,
    LeftOutRun,
    MeasurementChain,
    Report,
    Resolved,
)
from analysis.results.run import RunEnergy
from analysis.results.session_rows import CauseRow
from analysis.session.fidelity import Fidelity
from analysis.session.ledger_columns import CLOSURE
from analysis.session.prediction_entry import VARIANTS, entries_of
from analysis.session.protocol import ExpectedClaim, RigValue
from analysis.session.record import ChannelFacts
from analysis.session.setting import Setting
from analysis.shared_work import ForEach, both, here
from analysis.uncertainty.budget_line import Line
from analysis.uncertainty.estimate import Estimate
from daq.documents.classes import finite

__all__ = ["agreement"]


def agreement(
    runs: Iterable[RunEnergy],
    conditions: Mapping[str, Mapping[str, Any]],
    prediction: Mapping[str, Any] | None,
    channels: Mapping[str, ChannelFacts],
    *,
    protocol: str = "",
    question: str = "",
    synthetic: bool = False,
    assumed: Sequence[RigValue] = (),
    left_out: Sequence[LeftOutRun] = (),
    expect: Iterable[ExpectedClaim] = (),
    actual: Actual | None = None,
    fidelity: Fidelity | None = None,
    resolved: Resolved | None = None,
    loop_backs: Sequence[LoopBack] = (),
    sweeps: Sequence[SweepCurve] = (),
    each: ForEach = here,
) -> Report:
    """Return the report of a session.

    runs: energies of its runs. conditions: documents of the session by id, in the order to report.
    prediction: as the session's document, {"conditions": {id: {"acceleration": [m/s^2], "W_T": [J],
    ...}}} with the keys of `analysis.session.prediction_entry`, None for none: plain numbers, so
    that a laboratory can supply its own. channels: channel table with "force" and "acceleration".
    assumed: values of the rig file. left_out: runs that could not be used. expect: claims to judge.
    actual: the true states of the instruments, for the terms of the offset (simulated sessions
    only). fidelity: resolution and length of each condition's simulation, where a tolerance chose
    them. resolved: protocol and rig file written out. loop_backs: results of the runs with one
    voltage at both inputs. sweeps: of the runs that sweep, which state no energy. each: evaluates
    the conditions, here or in several processes.

    Numbers in SI, energies in J per cycle; None for unknown values, and for degrees of freedom
    without bound.
    """
    settings = {name: Setting.of(condition) for name, condition in conditions.items()}
    grouped: dict[str, list[RunEnergy]] = defaultdict(list)
    for run in runs:
        grouped[run.condition].append(run)
    entries = entries_of(prediction)
    seen = [setting for name, setting in settings.items() if grouped[name]]
    found = evaluated(seen, grouped, entries, channels, actual, each)
    results = [one.result for one in found]
    empties = {_level(r.setting): r for r in results if r.setting.is_empty}
    nulls = null_tests(settings, grouped, channels) + loop_back_nulls(loop_backs, channels)
    closure = _closure(results)
    known = references(results, channels)
    tests = [test for null in nulls for test in null.tested]
    tests += [test for reference in known for test in reference.tested]

    # None of these needs the critical score, whose joint draws take as long.
    def alone() -> tuple[tuple[ConditionRow, ...], tuple[CauseRow, ...], tuple[ClaimRow, ...]]:
        by_id = {result.setting.id: result for result in results}
        rows = tuple(_row(one, empties.get(_level(one.result.setting))) for one in found)
        return rows, causes(results, channels, assumed), judge(expect, by_id)

    def bound() -> float:
        return critical_score([*tests, *sign_tests(results)], chain_tests(results))

    (rows, candidates, claims), limit = both(each, alone, bound)
    nulls = tuple(null.judged(limit) for null in nulls)
    known = tuple(reference.judged(limit) for reference in known)
    known = (signs(results, limit), *known) if results else ()
    judged = verdict(results, nulls, known, closure, left_out, sweeps, limit)
    used = [r.setting for r in results] + [settings[one.condition] for one in sweeps]
    ideal = synthetic and all(setting.drive == "prescribed" for setting in used)
    report = Report(
        schema=SCHEMA,
        protocol=protocol,
        question=question,
        synthetic=synthetic,
        tests="measurement" if synthetic and is_mechanism_shared(used, entries) else "model",
        waveform="ideal" if ideal else "measured",
        prediction=predictions_named(results),
        support=tuple(
            sorted({setting.support for setting in settings.values() if setting.support})
        ),
        conditions=rows,
        agreement=agreement_row(results),
        comparisons=comparisons(results),
        causes=candidates,
        claims=claims,
        nulls=tuple(null.row() for null in nulls),
        references=tuple(reference.row() for reference in known),
        ledger=LedgerCheck(closure),
        chain=MeasurementChain(judged.chain_share, CHAIN_SHARE),
        verdict=judged.verdict,
        reasons=judged.reasons,
        failures=judged.failures,
        flags=_flags(results, sweeps) + (_too_coarse(results, fidelity) if fidelity else ()),
        waveforms=waveforms(results),
        left_out=tuple(left_out),
        instruments=tuple(_instrument(channel) for channel in channels.values()),
        assumed=tuple(assumed),
        sweeps=tuple(sweeps),
        resolved=resolved,
        fidelity=fidelity,
        deliberate_error=deliberate(results, channels),
    )
    return finite(report)


def _level(setting: Setting) -> tuple[Any, ...]:
    """Return the settings that a condition has in common with the empty box that it is compared
    with.
    """
    return setting.drive, setting.frequency, setting.acceleration_set, *setting.places


def _row(found: Evaluated, empty: Result | None) -> ConditionRow:
    """Return a condition's entry in the report; empty: the empty box at its level."""
    result, refills = found.result, found.refills
    setting, exp, got = result.setting, result.W_exp, result.predicted
    W = [run.energy.W for run in result.runs]
    n = len(W)
    distortions = [
        d for d in (box_distortion(run, setting) for run in result.runs) if d is not None
    ]
    stated = result.W_T is not None and result.comparable
    offset = _offset(result, exp.value, result.W_T) if stated else None
    difference = result.difference if stated else None
    model, recorded, at_box = model_columns(result), _recorded(result), _at_box(result)
    printed, layers, column = (result.others.get(name) for name in VARIANTS)
    low, high = result.band or (model.W_T_low, model.W_T_high)
    return ConditionRow(
        id=setting.id,
        material=setting.material,
        density=setting.density,
        diameter=setting.diameter,
        fill=setting.fill,
        bed=setting.bed,
        drive=setting.drive,
        bed_mass=setting.bed_mass,
        frequency=setting.frequency,
        acceleration_set=setting.acceleration_set,
        acceleration=result.mean("level"),
        period=got.period,
        periodic_share=got.periodic_share,
        dKE_bed=result.ledger_mean("dKE_bed"),
        runs=tuple(_run_row(run) for run in result.runs),
        W_exp=exp.value,
        s_W_exp=math.sqrt(math.fsum((w - exp.value) ** 2 for w in W) / (n - 1)) if n > 1 else None,
        U_W_exp=exp.U,
        k=exp.k,
        nu=exp.nu,
        W_net=None if empty is None else exp.value - empty.W_exp.value,
        W_detect=result.detect,
        eta=result.loss.value,
        U_eta=result.loss.U,
        M_eff=result.mass.value,
        U_M_eff=result.mass.U,
        force=result.mean("force_level"),
        force_phase=result.mean("force_phase"),
        thd_force=result.mean("thd_force"),
        thd_acceleration=result.mean("thd_acceleration"),
        thd_box=math.fsum(distortions) / n if len(distortions) == n else None,
        W_T=got.W_T,
        U_W_T=result.W_T.U if result.W_T else None,
        W_f=got.W_f,
        W_c=got.W_c,
        W_T_as_printed=printed.value if printed else got.W_T_as_printed,
        U_W_T_as_printed=printed.U if printed else None,
        W_T_layers=layers.value if layers else None,
        U_W_T_layers=layers.U if layers else None,
        W_T_column=column.value if column else None,
        U_W_T_column=column.U if column else None,
        prediction=result.prediction,
        inside=result.inside,
        reasons=result.reasons,
        bound=got.bound,
        exponent=got.exponent,
        offset=offset.value if offset else None,
        U_offset=offset.U if offset else None,
        E_n=_E_n(difference),
        E_n_truth=_E_n(result.chain),
        W_T_low=low,
        W_T_high=high,
        E_n_model=model.E_n_model,
        refill_mean=refills.refill_mean,
        refill_skew=refills.refill_skew,
        refill_coverage=refills.refill_coverage,
        refill_coverage_plain=refills.refill_coverage_plain,
        refills_needed=refills.refills_needed,
        W_T_recorded=recorded.W_T,
        U_W_T_recorded=recorded.U_W_T,
        offset_recorded=recorded.offset,
        U_offset_recorded=recorded.U_offset,
        E_n_recorded=recorded.E_n,
        W_coil=result.coil.value if result.coil else None,
        U_W_coil=result.coil.U if result.coil else None,
        E_n_coil=_E_n(result.coil_apart),
        gauge=setting.gauge if at_box else None,
        accelerometer=setting.accelerometer if at_box else None,
        W_at_box=at_box[0] if at_box else None,
        M_eff_at_box=at_box[1] if at_box else None,
        uncertainty=tuple(
            _budget_row(line, line.c, line.part, exp.u) for line in result.lines if line.c
        ),
        uncertainty_W_T=_budget_of_W_T(result),
        offset_terms=found.terms,
        allowed_remainder=allowed_remainder(result),
        varied=setting.varied,
    )


def _budget_of_W_T(result: Result) -> tuple[SourceRow, ...]:
    """Return the budget of W_T; empty without a prediction."""
    W_T = result.W_T
    if W_T is None:
        return ()
    return tuple(
        _budget_row(line, line.c_T, line.part_T, W_T.u) for line in result.lines if line.c_T
    )


def _budget_row(line: Line, sensitivity: float, part: float, u: float) -> SourceRow:
    """Return a line of the budget of W_exp or W_T, whose standard uncertainty is u (J).

    sensitivity: J per unit of the line; part: J; its fraction of u^2 is `share`.
    """
    nu = None if math.isinf(line.nu) else line.nu
    return SourceRow(line.source, line.unit, line.u, sensitivity, nu, (part / u) ** 2 if u else 0.0)


def _at_box(result: Result) -> tuple[float, float] | None:
    """Return W (J) and apparent mass (kg), means over the runs, corrected for the positions of
    gauge and accelerometer.

    None where these are not known.
    """
    found = [run.at_box for run in result.runs if run.at_box is not None]
    if len(found) < len(result.runs):
        return None
    n = len(found)
    return math.fsum(one.W for one in found) / n, math.fsum(one.M_eff for one in found) / n


@dataclass(frozen=True, slots=True)
class RecordedColumns:
    """The columns of a condition for W_T on the recorded waveforms; None for unknown values."""

    W_T: float | None = None
    U_W_T: float | None = None
    offset: float | None = None
    U_offset: float | None = None
    E_n: float | None = None


def _recorded(result: Result) -> RecordedColumns:
    """Return the columns of a condition for W_T on the recorded waveforms.

    The offset is None where W_T or W_exp is below the detection limit.
    """
    found = result.recorded
    if found is None:
        return RecordedColumns()
    offset = _offset(found, result.W_exp.value, found.W_T) if result.comparable_recorded else None
    return RecordedColumns(
        W_T=found.W_T.value,
        U_W_T=found.W_T.U,
        offset=offset.value if offset else None,
        U_offset=offset.U if offset else None,
        E_n=_E_n(found.difference),
    )


def _offset(source: Result | Recorded, W: float, W_T: Estimate | None) -> Estimate | None:
    """Return W/W_T - 1 with the uncertainty from both budgets.

    Its derivatives are 1/W_T to W and -W/W_T^2 to W_T.
    """
    if W_T is None:
        return None
    return propagated(W / W_T.value - 1, [(source, 1 / W_T.value, -W / W_T.value**2)])


def _run_row(run: RunEnergy) -> RunRow:
    """Return a run's entry in the report."""
    energy = run.energy
    return RunRow(
        run=run.run, order=run.order, repeat=run.repeat, acceleration=energy.level,
        W_exp=energy.W, W_exc=energy.W_exc, W_kin=energy.W_kin, W_phasor=energy.W_phasor,
        W_eq25=energy.W_eq25, W_coil=run.coil.W if run.coil else None,
        W_T_recorded=run.recorded,
        cycles=energy.cycles, flags=run.flags, clip_ratio=run.clip_ratio,
    )  # fmt: skip


def _E_n(difference: Estimate | None) -> float | None:
    """Return the E_n score: the difference over its expanded uncertainty; None without one."""
    return None if difference is None or not difference.U else difference.value / difference.U


def _closure(results: Sequence[Result]) -> float | None:
    """Return the largest relative error of the energy account; None without truth."""
    ledgers = [run.ledger for result in results for run in result.runs if run.ledger is not None]
    return max((ledger[CLOSURE] for ledger in ledgers if CLOSURE in ledger), default=None)


def _flags(results: Sequence[Result], sweeps: Sequence[SweepCurve]) -> tuple[FlagRow, ...]:
    """Return every flag with the runs that carry it, in the order of first appearance, and the
    largest utilisation of a limit.
    """
    runs: dict[str, list[tuple[str, Mapping[str, float]]]] = defaultdict(list)
    every = [(run.run, run.flags, run.use) for result in results for run in result.runs]
    every += [(one.run, one.flags, one.use) for one in sweeps]
    for name, flags, use in every:
        for flag in flags:
            runs[flag].append((name, use))
    rows = []
    for flag, found in runs.items():
        limit = flag.removeprefix("over_")
        used = [use[limit] for _, use in found if limit in use]
        rows.append(FlagRow(flag, max(used, default=None), tuple(name for name, _ in found)))
    return tuple(rows)


def _too_coarse(results: Sequence[Result], fidelity: Fidelity) -> tuple[FlagRow, ...]:
    """Return the flag of the conditions whose predicted error exceeds the tolerance that was asked
    for.
    """
    over = {
        row.id: (row.error or 0.0) / fidelity.tolerance
        for row in fidelity.conditions
        if not row.met
    }
    runs = tuple(run.run for result in results if result.setting.id in over for run in result.runs)
    return (FlagRow("over_tolerance", max(over.values()), runs),) if runs else ()


def _instrument(channel: ChannelFacts) -> InstrumentRow:
    """Return a channel's certified values for the report."""
    return InstrumentRow(
        channel=channel.name,
        model=channel.model,
        unit=channel.unit,
        sensitivity=channel.sensitivity,
        time_constant=channel.time_constant,
        calibration_U=channel.calibration_U,
        gain_tolerance=channel.gain_tolerance,
        noise_rms=channel.noise_rms,
    )
