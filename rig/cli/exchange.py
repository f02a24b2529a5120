"""`rig export` and `rig import`: other tools' files."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from daq.formats.uff58 import write_uff58
from daq.formats.wave import Spectrum, waves_of
from daq.formats.writing import write_csv, write_mat, write_sep005
from daq.session import Record, RunInfo
from rig.cli.output import PASSES, print_json, print_result
from rig.cli.progress import progress
from rig.cli.sessions import session_file
from rig.cli.watch import open_watched
from rig.errors import InputError, Mistake, nearest

SUFFIXES: Mapping[str, str] = {"uff58": ".uff", "csv": ".csv", "sep005-npz": ".npz", "mat": ".mat"}


def export_session(session: Path, to: str, run: str | None, out: Path | None, as_json: bool) -> None:
    """`rig export`: a file per run in the folder `out`, else in the session's folder `export`; `out` itself for one."""
    if to not in SUFFIXES:
        raise InputError(Mistake("--to", "", repr(to), ", ".join(SUFFIXES), nearest(to, SUFFIXES)))
    path = session_file(session)
    with open_watched(path) as record, progress("runs", as_json) as watch:
        runs = _chosen(record, run)
        written: list[str] = []
        for info in runs:
            file = out if out is not None and run is not None else (out or path.parent / "export") / info.name
            file = file if out is not None and run is not None else file.with_suffix(SUFFIXES[to])
            file.parent.mkdir(parents=True, exist_ok=True)
            _writer(to)(file, record, info)
            written.append(str(file))
            watch(len(written), len(runs))
    if as_json:
        print_json({"written": written})
        return
    for name in written:
        print(name)


def import_session(files: Sequence[Path], mapping: Path, out: Path, force: bool, as_json: bool) -> int:
    """`rig import`: session and report; 0 where the verdict passes, 1 where it does not."""
    from analysis import read_session, write_report
    from rig.campaign.importing import import_records
    from rig.mapping import read_mapping

    path = out if out.suffix == ".h5" else out / "session.h5"
    if path.exists() and not force:
        raise InputError(Mistake("--out", "", f"{path}, which exists", "a new path, or --force to replace it"))
    import_records(files, read_mapping(mapping), path, force)
    with open_watched(path) as record:
        report = read_session(record)
    write_report(report, path.parent)
    if as_json:
        print_json(report)
    else:
        print_result(report, path.parent)
    return 0 if report["verdict"] == PASSES else 1


def _chosen(record: Record, run: str | None) -> list[RunInfo]:
    """The runs asked for: a name, a number, or all complete ones."""
    names = [info.name for info in record.runs]
    if run is not None:
        name = f"run_{int(run):04d}" if run.isdecimal() else run
        if name not in names:
            raise InputError(Mistake("--run", "", repr(run), f"{names[0]} to {names[-1]}", nearest(name, names)))
        return [record.run(name)]
    complete = [info for info in record.runs if info.complete]
    if not complete:
        raise InputError(Mistake("SESSION", "", "no complete run", "at least one, or --run for what there is of one"))
    return complete


def _writer(to: str) -> Callable[[Path, Record, RunInfo], None]:
    def facts(record: Record, info: RunInfo) -> dict[str, Any]:
        condition = record.conditions[info.condition]
        return {"run": info.name, "order": info.order, "repeat": info.repeat, "condition": condition}

    def uff58(path: Path, record: Record, info: RunInfo) -> None:
        waves = waves_of(record, info.name)
        write_uff58(
            path, f"{info.name}, condition {info.condition}, repeat {info.repeat}", waves, _spectra(record, info)
        )

    return {
        "uff58": uff58,
        "csv": lambda path, record, info: write_csv(path, waves_of(record, info.name), facts(record, info)),
        "mat": lambda path, record, info: write_mat(path, waves_of(record, info.name), facts(record, info)),
        "sep005-npz": lambda path, record, info: write_sep005(path, waves_of(record, info.name)),
    }[to]


def _spectra(record: Record, info: RunInfo) -> list[Spectrum]:
    """Accelerance at the drive's harmonics, poles and delays corrected; none for a run that cannot be analysed."""
    from analysis import AnalysisError, run_energy

    try:
        energy = run_energy(record, info.name).energy
    except AnalysisError:
        return []
    force = np.where(energy.force == 0, np.nan, energy.force)
    values = np.nan_to_num(energy.acceleration / force)
    return [Spectrum("acceleration", "force", "(m/s^2)/N", values, energy.frequency)]
