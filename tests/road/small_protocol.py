"""A small protocol: three beds, three levels, two repeats."""

import subprocess
from collections.abc import Callable

SMALL = """\
schema: rig/protocol/1
name: small
rig: paper
scene: {grains: {material: stainless, diameter: 8 mm, fill: 85 %}}
acquire: {settle: 10 cycles, record: 40 cycles}
vary:
  scene.bed: [empty, layers, locked]
  drive.acceleration: [2 m/s^2, 3 m/s^2, 4 m/s^2]
repeats: 2
seed: 7
"""

IDEAL = (
    "acquire.analyzer=ideal",
    "acquire.sensors={force: ideal, acceleration: ideal}",
    "drive.imperfection=none",
)

Rig = Callable[..., subprocess.CompletedProcess[str]]
"""Calls the command `rig` with words."""
