"""The commands, one function each; exit code 0 done, 1 check failed, 2 bad input, 3 interrupted."""

import gc
import os
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from rig.cli.errors import Commands, with_whole_output
from rig.cli.options import (
    DEFAULTS,
    ForceFile,
    ForceSession,
    Json,
    ProtocolFile,
    RigFile,
    Seed,
    SessionPlace,
    Sets,
    Speed,
    Strict,
    Varies,
    Version,
    campaign_for,
    loaded_protocol,
    speed_of,
)

app = typer.Typer(
    cls=Commands,
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    help="Virtual test rig for particle dampers: run a protocol, read the records, compare with the model.",
    epilog="Start with: rig init, then rig check protocol.yaml, then rig run protocol.yaml",
)


@app.callback()
def options(version: Version = False) -> None:
    """Virtual test rig for particle dampers: run a protocol, read the records, compare with the
    model.
    """


@app.command()
def run(
    protocol: ProtocolFile,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder; default sessions/NAME.")
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(min=1, max=256, help="Worker processes; results do not depend on it."),
    ] = None,
    speed: Speed = "max",
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue an interrupted session.")
    ] = False,
    seed: Seed = None,
    rig: RigFile = None,
    strict: Strict = False,
    ablate: Annotated[
        bool,
        typer.Option(
            "--ablate",
            help="Simulate each bed a second time in the exact waveform: `waveform` in the offset.",
        ),
    ] = False,
    force: ForceSession = False,
    set_: Sets = None,
    vary: Varies = None,
    json: Json = False,
) -> None:
    """Run every condition and repeat; write the session and its report.

    Example: rig run fill_rate --workers 2
    """
    from rig.cli.commands.run import run_protocol

    campaign = campaign_for(protocol, set_, vary, seed, rig)
    folder = out if out is not None else Path("sessions") / campaign.protocol.name
    campaign = replace(campaign, ablate=ablate)
    raise typer.Exit(
        run_protocol(campaign, folder, workers, speed_of(speed), resume, force, strict, json)
    )


@app.command()
def check(
    protocol: ProtocolFile, seed: Seed = None, rig: RigFile = None, strict: Strict = False,
    set_: Sets = None, vary: Varies = None, json: Json = False,
) -> None:  # fmt: skip
    """Validate a protocol and predict exciter use, ranges, disk, time, expected W and uncertainty.

    Exit code 1 where a level, a range or a tolerance will not be kept.

    Example: rig check fill_rate --set drive.acceleration="8 m/s^2"
    """
    from rig.cli.commands.check import check_protocol

    raise typer.Exit(check_protocol(campaign_for(protocol, set_, vary, seed, rig), strict, json))


@app.command()
def model(
    protocol: Annotated[
        str | None, typer.Argument(metavar="[PROTOCOL]", help="Protocol file or name.")
    ] = None,
    rig: RigFile = None,
    set_: Sets = None,
    vary: Varies = None,
    study: Annotated[
        str | None, typer.Option(metavar="NAME", help="friction, collision or errata, in place.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder of a study; default studies/NAME.")
    ] = None,
    json: Json = False,
) -> None:
    """Print W_T in every variant with W_f, W_c and the bound; no simulation of the stand.

    With --study: the paper's Figs. 5 to 8, or its errata with their numbers, as figures, CSV and a
    table.

    Example: rig model --set scene.grains.diameter="5 mm" --vary drive.acceleration=[2,4,6]
    """
    if study is not None:
        from rig.cli.commands.study import study_files

        study_files(study, out, json)
        return
    from rig.cli.commands.model import model_table

    model_table(loaded_protocol(protocol or DEFAULTS, set_, vary, None, rig), json)


@app.command()
def replay(
    session: SessionPlace,
    speed: Speed = "max",
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Write a second session and its report there."),
    ] = None,
    force: ForceSession = False,
    json: Json = False,
) -> None:
    """Feed a recorded session through recorder, analysis and report again: same codes, same report.

    Example: rig replay sessions/fill_rate --speed 10 --out sessions/again
    """
    from rig.cli.terminal.watch import go_on_watched

    go_on_watched(session)
    from rig.cli.commands.replay import replay_session

    raise typer.Exit(replay_session(session, out, speed_of(speed), force, json))


@app.command()
def report(
    session: Annotated[
        list[Path], typer.Argument(metavar="SESSION...", help="Session files or their folders.")
    ],
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Report folder; default: the session's.")
    ] = None,
    tolerate_gaps: Annotated[
        bool,
        typer.Option(
            "--tolerate-gaps", help="Read the whole cycles beside a gap; never across one."
        ),
    ] = False,
    png: Annotated[bool, typer.Option("--png", help="Write the figures as PNG files too.")] = False,
    same_instruments: Annotated[
        bool,
        typer.Option(
            "--same-instruments", help="Two sessions: recorded with the same transducers."
        ),
    ] = False,
    json: Json = False,
) -> None:
    """Analyse a recorded session again, from the record alone; of two sessions, compare them.

    Example: rig report sessions/fill_rate sessions/shaker_fill --out compared
    """
    from rig.cli.terminal.watch import go_on_watched

    go_on_watched(*session)
    from rig.cli.commands.sessions import compare_sessions, report_sessions

    if len(session) == 2:
        raise typer.Exit(compare_sessions(session, out, json, same_instruments, tolerate_gaps))
    raise typer.Exit(report_sessions(session, out, json, tolerate_gaps, png))


@app.command()
def info(
    session: SessionPlace,
    validate: Annotated[
        bool,
        typer.Option(
            "--validate",
            help="List every deviation from the session format; exit 1 where there is one.",
        ),
    ] = False,
    json: Json = False,
) -> None:
    """Show what is in a session: conditions, completeness, flags, channels, provenance.

    Example: rig info sessions/fill_rate
    """
    from rig.cli.terminal.watch import go_on_watched

    go_on_watched(session)
    from rig.cli.commands.sessions import session_info, validate_session

    if validate:
        raise typer.Exit(validate_session(session, json))
    session_info(session, json)


@app.command("export")
def export_(
    session: SessionPlace,
    to: Annotated[str, typer.Option(metavar="FORMAT", help="uff58, csv, sep005-npz or mat.")],
    run: Annotated[
        str | None, typer.Option(metavar="K", help="One run, by name or number; else all.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="PATH", help="Folder; with --run the file.")
    ] = None,
    raw: Annotated[
        bool, typer.Option("--raw", help="As recorded: poles and delays are left in.")
    ] = False,
    force: Annotated[
        bool, typer.Option("--force", help="Replace files that are no exports.")
    ] = False,
    json: Json = False,
) -> None:
    """Write records for other tools: UFF58 (types 1 and 4), CSV, SEP-005, MATLAB.

    Poles and delays of the channels are corrected, so that W from the file is that of the report. A
    JSON file beside each states flags, certificates and where the whole cycles begin; rig import
    reads it.

    Example: rig export sessions/fill_rate --to uff58 --run 3
    """
    from rig.cli.terminal.watch import go_on_watched

    go_on_watched(session)
    from rig.cli.commands.exchange import export_session

    export_session(session, to, run, out, raw, json, force)


@app.command("import")
def import_(
    file: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", help="Records, one run each, or their folder."),
    ],
    map_: Annotated[Path, typer.Option("--map", metavar="MAP.yaml", help="What the columns mean.")],
    out: Annotated[
        Path, typer.Option(metavar="SESSION", help="Session file (.h5), or a folder for it.")
    ],
    force: ForceSession = False,
    json: Json = False,
) -> None:
    """Turn a laboratory's own records of force and acceleration into a session and its report.

    Reads CSV, UFF58, SEP-005, TDMS, MATLAB and HDF5. Walk through: docs/your-own-data.md

    Example: rig import record.csv --map map.yaml --out sessions/mine
    """
    from rig.cli.terminal.watch import go_on_watched

    go_on_watched(*file)
    from rig.cli.commands.exchange import import_session

    raise typer.Exit(import_session(file, map_, out, force, json))


@app.command()
def calibrate(
    protocol: ProtocolFile,
    target: Annotated[
        float, typer.Option(help="Offset of the energy-weighted ratio that the losses shall cause.")
    ],
    out: Annotated[Path, typer.Option(metavar="RIG.yaml", help="Rig file to write.")],
    seed: Seed = None,
    rig: RigFile = None,
    set_: Sets = None,
    vary: Varies = None,
    force: ForceFile = False,
    json: Json = False,
) -> None:
    """Set the emulated rig's losses once, from the ledger (not a calibration in the metrological
    sense).

    Example: rig calibrate density --target 0.07 --out my_rig.yaml
    """
    from rig.cli.commands.calibrate import calibrate_rig

    calibrate_rig(campaign_for(protocol, set_, vary, seed, rig), target, out, force, json)


@app.command()
def bench(
    quick: Annotated[
        bool, typer.Option("--quick", help="Fewer problems, settings, rounds: under a minute.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder for bench.jsonl, performance.md and figures."),
    ] = None,
    json: Annotated[
        bool, typer.Option("--json", help="Print the rows as JSON lines and nothing else.")
    ] = False,
) -> None:
    """Speed against error: our integrators beside others, the parts of the rig, how cost grows.

    Example: rig bench --quick --out bench
    """
    from rig.cli.commands.bench import bench as run_bench

    raise typer.Exit(run_bench(quick, out, json))


@app.command()
def init(
    path: Annotated[Path, typer.Argument(metavar="[FILE]", help="Where to write.")] = Path(
        "protocol.yaml"
    ),
    force: ForceFile = False,
) -> None:
    """Write a commented protocol to start from.

    Example: rig init my_test.yaml
    """
    from rig.cli.terminal.files import write_new
    from rig.cli.terminal.output import say
    from rig.protocol.load import protocol_template

    write_new(path, protocol_template(), force)
    say(f"Wrote {path}. Next: rig check {path}")


@app.command()
def catalog(
    kind: Annotated[
        str,
        typer.Argument(metavar="[KIND]", help="material, exciter, transducer, analyzer or rig."),
    ] = "",
    json: Json = False,
) -> None:
    """List materials, exciters, transducers, analyzers and rigs, every value with its status and
    source.

    Example: rig catalog exciter
    """
    from rig.cli.commands.catalog import catalog_table

    catalog_table(kind, json)


@app.command()
def schema(
    kind: Annotated[
        str, typer.Argument(metavar="[KIND]", help="protocol, report, comparison or map.")
    ] = "protocol",
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write it there instead of printing it.")
    ] = None,
    force: ForceFile = False,
) -> None:
    """Print a JSON Schema for editors (protocol, map of an import) or for readers of report.json
    and comparison.json.

    Example: rig schema protocol --out protocol.schema.json
    """
    from rig.cli.commands.schema import schema_text

    schema_text(kind, out, force)


def main() -> None:
    """Run the command line.

    A high threshold keeps the garbage collector from running during the heavy imports. Linear
    algebra gets one thread, unless the user says otherwise: its products are small, and on a busy
    machine its threads wait for each other longer than they compute.
    """
    gc.set_threshold(100_000)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with_whole_output(app)
