"""The command `rig`. Heavy imports happen inside the commands: `rig --help` needs none of them."""

from rig.cli.app import main

__all__ = ["main"]
