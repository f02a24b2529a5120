"""Options and arguments that several commands share, and the values that they stand for.

Imports are inside the functions: `rig --help` needs none of them.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rig.campaign.campaign import Campaign
    from rig.protocol.load import LoadedProtocol


def _version(asked: bool) -> None:
    """Print the version and end, if asked to."""
    if asked:
        from importlib.metadata import version

        typer.echo(version("particle-damper-rig"))
        raise typer.Exit


Version = Annotated[
    bool,
    typer.Option("--version", is_eager=True, callback=_version, help="Print the version and exit."),
]
ProtocolFile = Annotated[
    str, typer.Argument(metavar="PROTOCOL", help="Protocol file (YAML) or shipped name.")
]
Sets = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="PATH=VALUE", help="Replace one value, e.g. scene.bed=locked."),
]
Varies = Annotated[
    list[str] | None,
    typer.Option(
        "--vary",
        metavar="PATH=LIST",
        help="Replace or add one axis, e.g. scene.grains.fill=[0.5,0.9].",
    ),
]
Seed = Annotated[int | None, typer.Option(help="Session seed instead of the protocol's.")]
RigFile = Annotated[
    str | None, typer.Option("--rig", metavar="FILE", help="Rig file or catalog name.")
]
Json = Annotated[bool, typer.Option("--json", help="Print results as JSON and nothing else.")]
Strict = Annotated[
    bool,
    typer.Option(
        "--strict", help="A rating exceeded (fundamental) is an error before anything runs."
    ),
]
SessionPlace = Annotated[
    Path, typer.Argument(metavar="SESSION", help="Session file or its folder.")
]
Speed = Annotated[
    str, typer.Option(metavar="max|1|N", help="Pace: rig seconds per second, or max.")
]
ForceSession = Annotated[bool, typer.Option("--force", help="Replace an existing session.")]
ForceFile = Annotated[bool, typer.Option("--force", help="Replace an existing file.")]

DEFAULTS = "schema: rig/protocol/1\nname: defaults\n"
"""A protocol of defaults only, for `rig model` without one."""


def loaded_protocol(
    source: str, sets: list[str] | None, varies: list[str] | None, seed: int | None, rig: str | None
) -> "LoadedProtocol":
    """Return a protocol file or name, with the command line's changes."""
    from rig.protocol.load import read_protocol

    return read_protocol(source, sets or (), varies or (), seed, rig)


def campaign_for(
    source: str, sets: list[str] | None, varies: list[str] | None, seed: int | None, rig: str | None
) -> "Campaign":
    """Return the resolved campaign of a protocol file or name, with the command line's changes."""
    from rig.campaign.resolve import campaign_of
    from rig.catalog.rig_file import load_rig
    from rig.cli.terminal.output import say_compiling
    from rig.kernels.compiling import tell_of_compiling

    loaded = loaded_protocol(source, sets, varies, seed, rig)
    tell_of_compiling(say_compiling)
    return campaign_of(loaded.protocol, load_rig(loaded.protocol.rig), loaded.text)


def speed_of(text: str) -> float | None:
    """Return rig seconds per wall second, None for as fast as possible. Raises InputError."""
    from rig.errors import InputError, Mistake

    if text == "max":
        return None
    try:
        speed = float(text)
    except ValueError:
        speed = float("nan")
    if not 0.0 < speed < float("inf"):
        raise InputError(Mistake("--speed", "", repr(text), "max, 1, or a positive number"))
    return speed
