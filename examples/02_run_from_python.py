"""The same from Python: a protocol, a run, its report."""

from pathlib import Path

from rig import load_protocol, run

PROTOCOL = """\
schema: rig/protocol/1
name: two_fills
scene: {grains: {material: stainless, diameter: 8 mm}}
vary: {scene.grains.fill: [50 %, 90 %]}
repeats: 3
"""

report = run(load_protocol(PROTOCOL), Path("sessions/two_fills"), overwrite=True)
for row in report.conditions:
    print(
        f"fill {row.fill:.0%}: W_exp = {1e3 * row.W_exp:.1f} +- {1e3 * row.U_W_exp:.1f} mJ per cycle"
    )
print("verdict:", report.verdict)
