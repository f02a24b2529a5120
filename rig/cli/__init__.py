"""The command `rig`.

Commands import heavy modules inside their functions, so that `rig --help` needs none of them.
"""

from rig.cli.app import main

__all__ = ["main"]
