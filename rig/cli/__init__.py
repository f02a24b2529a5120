"""The command `rig` (`rig.cli.app.main`).

Commands import heavy modules inside their functions, so that `rig --help` needs none of them.
"""
