"""Scenes with other numbers of rows per layer."""

from dataclasses import replace

from rig.protocol.spec import Scene
from rig.theory.chain import grains_in_row


def resolved_rows(scene: Scene) -> int:
    """Rows of grains side by side across the drive axis, floor(L2/d), at least one."""
    return max(grains_in_row(scene.cavity.width, scene.grains.diameter), 1)


def with_rows(scene: Scene, rows: int) -> Scene:
    """The scene with so many rows per layer."""
    return replace(scene, layers=replace(scene.layers, rows=rows))


def side_by_side(scene: Scene) -> Scene:
    """The scene with as many rows per layer as lie side by side; one whose bed has no rows, or as many, as it is."""
    rows = resolved_rows(scene)
    return with_rows(scene, rows) if scene.bed == "layers" and scene.layers.rows < rows else scene
