"""`rig export` and `rig import`: exchange records with other tools."""

import hashlib
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from analysis.pipeline import window_range
from analysis.session.former_names import condition_today
from analysis.signals.corrected_signal import CorrectedSignal
from daq.chain.channel import ChannelInfo
from daq.formats.sidecar import SCHEMA, is_sidecar, sidecar_of
from daq.formats.uff58 import write_uff58
from daq.formats.wave import RecordedSignal, Samples, Spectrum, Wave
from daq.formats.writing import write_csv, write_mat, write_sep005
from daq.json_text import json_text
from daq.session.plan import RunInfo
from daq.session.record import Record
from daq.whole_files import write_whole
from rig.cli.commands.sessions import session_file
from rig.cli.terminal.output import print_json, print_result, say
from rig.cli.terminal.progress import progress
from rig.cli.terminal.watch import open_watched
from rig.errors import InputError, Mistake, nearest

SUFFIXES: Mapping[str, str] = {"uff58": ".uff", "csv": ".csv", "sep005-npz": ".npz", "mat": ".mat"}


def export_session(
    session: Path,
    to: str,
    run: str | None,
    out: Path | None,
    raw: bool,
    as_json: bool,
    force: bool = False,
) -> None:
    """Write one file per run into the folder `out`, by default the session's folder `export`; for
    one run `out` is the file.

    raw: leave poles and delays in the samples. force: replace files that are not exports; the
    session itself is never replaced.
    """
    if to not in SUFFIXES:
        raise InputError(Mistake("--to", "", repr(to), ", ".join(SUFFIXES), nearest(to, SUFFIXES)))
    path = session_file(session)
    with open_watched(path) as record, progress("runs", as_json) as watch:
        runs = _chosen(record, run)
        written: list[str] = []
        folder = out or path.parent / "export"
        one = out is not None and run is not None
        files = [folder if one else folder / f"{info.name}{SUFFIXES[to]}" for info in runs]
        for file in files:
            _check_target(file, path, force)
        for file, info in zip(files, runs, strict=True):
            file.parent.mkdir(parents=True, exist_ok=True)
            _write(file, to, record, info, raw)
            written.append(str(file))
            watch(len(written), len(runs))
    if as_json:
        print_json({"written": written})
        return
    for name in written:
        say(name)


def _check_target(file: Path, session: Path, force: bool) -> None:
    """Raise InputError for a target whose replacement would cost the user a file: the session, or a
    file not written by `rig export`.
    """
    beside = sidecar_of(file)
    for target in (file, beside):
        if target.is_dir():
            raise InputError(
                Mistake("--out", "", f"{target}, which is a folder", "the path of a file")
            )
        if target.exists() and target.samefile(session):
            raise InputError(
                Mistake("--out", "", f"{target}, which is the session itself", "another path")
            )
    # A record of ours is known by the file beside it; anything else may be the user's own work.
    known = is_sidecar(beside)
    for target in (file, beside):
        if os.path.lexists(target) and not known and not force:
            found = f"{target}, which exists and is no file of rig export"
            raise InputError(Mistake("--out", "", found, "a new path, or --force to replace it"))


def import_session(
    files: Sequence[Path], mapping: Path, out: Path, force: bool, as_json: bool
) -> int:
    """Write a session and its report; return the exit code 0 where the verdict passes, 1 where it
    does not.
    """
    from analysis.pipeline import read_session
    from analysis.report.files import write_report
    from rig.importing.mapping import read_mapping
    from rig.importing.to_session import import_records

    path = out if out.suffix == ".h5" else out / "session.h5"
    if path.exists() and not force:
        raise InputError(
            Mistake("--out", "", f"{path}, which exists", "a new path, or --force to replace it")
        )
    import_records(files, read_mapping(mapping), path, force)
    with open_watched(path) as record:
        report = read_session(record)
    write_report(report, path.parent)
    if as_json:
        print_json(report.document())
    else:
        print_result(report, path.parent)
    return 0 if report.passes else 1


def _chosen(record: Record, run: str | None) -> list[RunInfo]:
    """Return the runs selected by a name or a number, or all complete ones."""
    names = [info.name for info in record.runs]
    if run is not None:
        name = f"run_{int(run):04d}" if run.isdecimal() else run
        if name not in names:
            raise InputError(
                Mistake("--run", "", repr(run), f"{names[0]} to {names[-1]}", nearest(name, names))
            )
        return [record.run(name)]
    complete = [info for info in record.runs if info.complete]
    if not complete:
        raise InputError(
            Mistake(
                "SESSION", "", "no complete run", "at least one, or --run for what there is of one"
            )
        )
    return complete


def _write(path: Path, to: str, record: Record, info: RunInfo, raw: bool) -> None:
    """Write one run and, beside it, the facts for which its format has no field."""
    waves = exported_waves(record, info, raw)
    document = _beside(record, info, raw)
    if to == "uff58":
        done = "as recorded" if raw else "poles and delays undone"
        title = f"{info.name}, condition {info.condition}, repeat {info.repeat}, {done}"
        write_uff58(path, title, waves, _spectra(record, info))
    elif to == "csv":
        write_csv(path, waves)
    elif to == "mat":
        write_mat(path, waves, document)
    else:
        write_sep005(path, waves)
    with path.open("rb") as content:
        # Taken from the finished file, so that the document belongs to these bytes only.
        document["sha256"] = hashlib.file_digest(content, "sha256").hexdigest()
    write_whole(sidecar_of(path), json_text(document) + "\n")


def exported_waves(record: Record, info: RunInfo, raw: bool) -> tuple[Wave, ...]:
    """Return all channels of a run in engineering units, in the order of the channel table.

    Unless `raw`, poles are corrected, and each channel is shifted to the time of the first, which
    keeps its own delay.
    """
    channels = list(record.channels.values())
    window = window_range(record, info)
    reference = _delay(channels[0], info.rate)
    waves = []
    for channel in channels:
        recorded = RecordedSignal(record, info.name, channel.name)
        signal: Samples = recorded if raw else CorrectedSignal(
            recorded.read, recorded.size, window, 1 / info.rate, channel.time_constants,
            _delay(channel, info.rate) - reference,
        )  # fmt: skip
        waves.append(
            Wave(
                channel.name,
                channel.quantity,
                channel.unit,
                signal,
                info.rate,
                info.t0,
                channel.direction,
            )
        )
    return tuple(waves)


def _delay(channel: ChannelInfo, rate: float) -> float:
    """Return the delay of a channel's samples, s."""
    return channel.filter_delay / rate - channel.skew


def _beside(record: Record, info: RunInfo, raw: bool) -> dict[str, Any]:
    """Return the document for the file beside an exported record (daq.formats.sidecar)."""
    names = list(record.channels)
    first, last = window_range(record, info)
    condition = record.conditions[info.condition]
    period = info.rate / condition["frequency"]
    blocks = record.blocks(info.name)
    # Only blocks with a flag are listed: most records have none.
    flagged = blocks[(blocks["flags"] != 0).any(axis=1)]
    reference = _delay(record.channels[names[0]], info.rate)
    return {
        "schema": SCHEMA,
        "run": info.name,
        "order": info.order,
        "repeat": info.repeat,
        "condition": condition_today(condition),
        "corrected": not raw,
        "rate": info.rate,
        "start": info.t0,
        "window": {
            "start": first,
            "cycles": round((last - first) / period),
            "samples_per_cycle": period,
        },
        "flags": [
            {
                "start": int(block["start"]),
                "count": int(block["count"]),
                "flags": dict(zip(names, map(int, block["flags"]), strict=True)),
            }
            for block in flagged
        ],
        "channels": {
            channel.name: {
                "unit": channel.unit,
                "model": channel.model,
                "serial": channel.serial,
                "direction": channel.direction,
                "calibration_date": channel.calibration_date,
                "sensitivity": channel.sensitivity,
                "calibration_U": channel.calibration_U,
                "gain_tolerance": channel.gain_tolerance,
                "time_constants": list(channel.time_constants),
                "time_constant_spread": channel.time_constant_spread,
                "corner_tolerance": channel.corner_tolerance,
                "delay": _delay(channel, info.rate) - reference,
                "skew_tolerance": channel.skew_tolerance,
                "noise_rms": channel.noise_rms,
                "full_scale": channel.full_scale,
            }
            for channel in record.channels.values()
        },
    }


def _spectra(record: Record, info: RunInfo) -> list[Spectrum]:
    """Return the accelerance at the drive's harmonics, poles and delays corrected; empty for a run
    that cannot be analysed.
    """
    from analysis.pipeline import run_energy
    from analysis.session.record import AnalysisError

    try:
        energy = run_energy(record, info.name).energy
    except AnalysisError:
        return []
    values = np.divide(
        energy.acceleration, energy.force, out=np.zeros_like(energy.force), where=energy.force != 0
    )
    return [Spectrum("acceleration", "force", "(m/s^2)/N", values, energy.frequency)]
