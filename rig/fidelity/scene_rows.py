"""Scenes with different numbers of rows per layer."""

from dataclasses import replace

from rig.protocol.spec import Scene
from rig.theory.chain import grains_in_row


def resolved_rows(scene: Scene) -> int:
    """Return the number of rows of grains side by side across the drive axis, floor(L2/d), at least
    one.
    """
    return max(grains_in_row(scene.cavity.width, scene.grains.diameter), 1)


def with_rows(scene: Scene, rows: int) -> Scene:
    """Return the scene with `rows` rows per layer."""
    return replace(scene, layers=replace(scene.layers, rows=rows))


def side_by_side(scene: Scene) -> Scene:
    """Return the scene with as many rows per layer as lie side by side; unchanged if the bed has no
    rows, or already as many.
    """
    rows = resolved_rows(scene)
    return with_rows(scene, rows) if scene.bed == "layers" and scene.layers.rows < rows else scene
