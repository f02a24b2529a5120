"""What the commands do: call the campaign or the analysis, print tables or JSON, return the exit code."""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console

from analysis import read_session, write_report
from daq.block import flag_names
from daq.session import Record, open_session
from rig.campaign import Campaign
from rig.campaign import run as run_campaign
from rig.campaign.calibrate import calibrated
from rig.campaign.preflight import disk, preflight
from rig.catalog import dump_rig, listing, load_rig
from rig.cli.files import write_new
from rig.cli.live import live_view
from rig.cli.tables import number, print_report, table
from rig.errors import InputError, Mistake, nearest
from rig.model import predict
from rig.plan import model_row
from rig.protocol import LoadedProtocol

PASSES = "passes"
KINDS = ("material", "exciter", "transducer", "analyzer", "rig")


def run_protocol(
    campaign: Campaign, out: Path, workers: int | None, speed: float | None, resume: bool, force: bool, strict: bool,
    as_json: bool,
) -> int:  # fmt: skip
    """`rig run`: 0 where the verdict passes, 1 where it does not."""
    _check_folder(out, resume, force)
    count = workers or cores()
    console = Console(stderr=True, quiet=as_json)
    if strict:
        _refuse_beyond(campaign, count)
    with live_view(campaign, console) as view:
        report = run_campaign(campaign, out, count, speed, resume, force, view.step)
    if as_json:
        print_json(report)
    else:
        _print_result(report, out)
    return 0 if report["verdict"] == PASSES else 1


def check_protocol(campaign: Campaign, strict: bool, as_json: bool) -> int:
    """`rig check`: a line per condition; with --strict 2 where a limit is exceeded."""
    outlooks = list(preflight(campaign, cores()))
    cycles = {c.id: c.acquire.settle + c.acquire.record for c in campaign.conditions}
    repeats = campaign.protocol.repeats.n
    seconds = sum(o.seconds_per_cycle * cycles[o.id] for o in outlooks) * repeats / cores()
    totals = {
        "runs": len(campaign.runs),
        "rig_time_s": campaign.rig_time,
        "stand_time_s": seconds,
        "disk_bytes": disk(campaign),
    }
    if as_json:
        rows = [{**asdict(o), "flags": list(o.flags)} for o in outlooks]
        print_json({"conditions": rows, **{k: v for k, v in totals.items() if k != "stand_time_s"}})
    else:
        _print_outlook(outlooks, totals)
    return 2 if strict and any(o.beyond for o in outlooks) else 0


def _print_outlook(outlooks: Sequence[Any], totals: Mapping[str, float]) -> None:
    console = Console()
    rows = [
        (
            o.id, o.bed, f"{o.fill:.0%}", number(o.diameter * 1e3), number(o.acceleration), f"{o.samples_per_cycle:.0f}",
            *(f"{share:.2f}" for share in (o.exciter.force, o.exciter.current, o.exciter.voltage, o.exciter.stroke)),
            f"{o.exciter.peak:.2f}", f"{max(o.range_force, o.range_acceleration):.2f}",
        )
        for o in outlooks
    ]  # fmt: skip
    columns = ("id", "bed", "fill", "d/mm", "a", "S/cycle", "force", "current", "voltage", "stroke", "peak", "range")
    console.print(table("Shares of the exciter's and the front end's limits", columns, rows, ("id", "bed")))
    plan = [
        (
            o.id, number(o.W_T), number(o.W_exp), number(o.U_W_exp, 2), number(o.W_detect, 2),
            number(o.smallest_difference, 2),
        )
        for o in outlooks
    ]  # fmt: skip
    columns = ("id", "W_T/J", "W_exp/J", "U/J", "W_detect/J", "least difference/J")
    console.print(table("Plan: what the repeats will be able to tell (95 %)", columns, plan, ("id",)))
    for o in outlooks:
        for flag in o.flags:
            console.print(f"{o.id}: {flag}")
    console.print(
        f"{totals['runs']} runs, {totals['rig_time_s']:.0f} s of rig time, about {totals['stand_time_s']:.1f} s on the stand, "
        f"{totals['disk_bytes'] / 1e6:.1f} MB"
    )


def model_table(loaded: LoadedProtocol, as_json: bool) -> None:
    """`rig model`."""
    rig = load_rig(loaded.protocol.rig)
    rows = [model_row(condition, predict(condition, rig)) for condition in loaded.protocol.conditions()]
    if as_json:
        print_json({"conditions": rows})
        return
    lines = [
        (
            row["id"], row["material"], row["bed"], f"{row['fill']:.0%}", number(row["diameter"] * 1e3),
            number(row["acceleration"]), number(row["W_f"]), number(row["W_c"]), number(row["W_T"]),
            number(row["W_T_paper"]), number(row["bound"]), str(row["period"]),
        )
        for row in rows
    ]  # fmt: skip
    columns = ("id", "grains", "bed", "fill", "d/mm", "a", "W_f", "W_c", "W_T", "paper", "bound", "period")
    console = Console()
    console.print(table("Energy per cycle, J (closed tier; `paper` is the paper tier)", columns, lines,
                        ("id", "grains", "bed")))  # fmt: skip
    for row in rows:
        for name, label in (("W_T", "closed tier"), ("W_T_paper", "paper tier")):
            if row["bed"] == "layers" and row[name] > row["bound"]:
                console.print(f"{row['id']}: the {label} lies above the bound: impossible at this level")


def report_sessions(sessions: Sequence[Path], out: Path | None, as_json: bool) -> int:
    """`rig report`: analysis and agreement from the records alone."""
    if out is not None and len(sessions) > 1:
        raise InputError(Mistake("--out", "", f"{len(sessions)} sessions", "one session with --out"))
    reports = []
    for session in sessions:
        path = session_file(session)
        with open_session(path) as record:
            reports.append(read_session(record))
        folder = out or path.parent
        write_report(reports[-1], folder)
        if not as_json:
            _print_result(reports[-1], folder)
    if as_json:
        print_json(reports[0] if len(reports) == 1 else reports)
    return 0 if all(report["verdict"] == PASSES for report in reports) else 1


def session_info(session: Path, as_json: bool) -> None:
    """`rig info`."""
    with open_session(session_file(session)) as record:
        facts = _facts(record)
    if as_json:
        print_json(facts)
        return
    console = Console()
    for name in ("protocol", "schema", "synthetic", "complete", "truth", "rate"):
        console.print(f"{name}: {facts[name]}")
    console.print(table("Channels (certified)", ("name", "model", "unit", "V/unit", "range V", "pole Hz", "U(k=2)"), [
        (c["name"], c["model"], c["unit"], number(c["sensitivity"], 5), number(c["range_V"]), number(c["pole_Hz"]),
         number(c["calibration_U"]))
        for c in facts["channels"]
    ], ("name", "model", "unit")))  # fmt: skip
    console.print(table("Conditions", ("id", "grains", "bed", "fill", "d/mm", "a", "runs", "complete", "flags"), [
        (c["id"], c["material"], c["bed"], f"{c['fill']:.0%}", number(c["diameter"] * 1e3),
         number(c["acceleration_set"]), str(c["runs"]), str(c["complete_runs"]), " ".join(c["flags"]))
        for c in facts["conditions"]
    ], ("id", "grains", "bed", "flags")))  # fmt: skip
    for name, value in facts["provenance"].items():
        console.print(f"{name}: {value}", highlight=False)


def _facts(record: Record) -> dict[str, Any]:
    runs: dict[str, list[Any]] = {}
    for run in record.runs:
        runs.setdefault(run.condition, []).append(run)
    return {
        "protocol": (record.document("protocol") or {}).get("name", ""),
        "schema": record.schema,
        "synthetic": record.synthetic,
        "complete": record.complete,
        "truth": record.truth is not None,
        "rate": record.rate,
        "channels": [{**asdict(info), "pole_Hz": info.pole_Hz} for info in record.channels.values()],
        "conditions": [
            {
                **condition,
                "runs": len(runs.get(key, [])),
                "complete_runs": sum(run.complete for run in runs.get(key, [])),
                "flags": sorted({name for run in runs.get(key, []) for name in flag_names(run.flags)}),
            }
            for key, condition in record.conditions.items()
        ],
        "provenance": record.document("provenance") or {},
    }


def calibrate_rig(campaign: Campaign, target: float, out: Path, force: bool, as_json: bool) -> None:
    """`rig calibrate`: write a rig file with the losses that the target asks for."""
    if out.exists() and not force:
        raise InputError(Mistake(str(out), "", "a file that exists", "a new path, or --force to replace it"))
    rig = calibrated(campaign, target, cores())
    write_new(out, dump_rig(rig), force)
    facts = {"loss_noise": rig.loss_noise, "loss_air": rig.loss_air, "provenance": dict(rig.provenance)}
    if as_json:
        print_json(facts)
        return
    console = Console()
    console.print(f"noise {rig.loss_noise:.6g} N s/m, air {rig.loss_air:.6g} N s^2/m^2 -> {out}")
    for name, value in rig.provenance.items():
        console.print(f"  {name}: {number(value)}", highlight=False)


def catalog_table(kind: str, as_json: bool) -> None:
    """`rig catalog`."""
    if kind and kind not in KINDS:
        raise InputError(Mistake("rig catalog", "kind", repr(kind), ", ".join(KINDS), nearest(kind, KINDS)))
    rows = [row for row in listing() if kind in ("", row.kind)]
    if as_json:
        print_json([row._asdict() for row in rows])
        return
    lines = [
        (row.kind, row.name, row.field, number(row.value, 6), row.unit, row.status, row.source) for row in rows
    ]
    columns = ("kind", "name", "field", "value", "unit", "status", "source")
    Console().print(table("", columns, lines, ("kind", "name", "field", "unit", "status", "source")))


def session_file(session: Path) -> Path:
    """The session file itself, or the one in a folder."""
    return session / "session.h5" if session.is_dir() else session


def cores() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def print_json(value: Any) -> None:
    """JSON on standard output, nothing else."""
    print(json.dumps(value, indent=1, allow_nan=False))


def _print_result(report: Mapping[str, Any], folder: Path) -> None:
    console = Console()
    print_report(console, report)
    console.print(f"report: {folder / 'report.html'}", highlight=False, soft_wrap=True)


def _refuse_beyond(campaign: Campaign, workers: int) -> None:
    mistakes = [
        Mistake(outlook.id, "drive.acceleration", flag, "within the exciter's and the front end's limits (--strict)")
        for outlook in preflight(campaign, workers)
        for flag in outlook.beyond
    ]
    if mistakes:
        raise InputError(*mistakes)


def _check_folder(out: Path, resume: bool, force: bool) -> None:
    """Refuse a session that is there already, or a folder that cannot be written, before anything is computed."""
    if (out / "session.h5").exists() and not (resume or force):
        raise InputError(
            Mistake(str(out / "session.h5"), "", "a session that exists", "--resume to go on with it, --force to replace it")
        )
    place = out
    while not place.exists():
        place = place.parent
    if not place.is_dir() or not os.access(place, os.W_OK):
        raise InputError(Mistake(str(out), "", f"{place} cannot be written", "a writable folder"))
