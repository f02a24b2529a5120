"""The same grains twice: an ideal waveform (prescribed) and the exciter in the loop (shaker), same
seed, same refills.
"""

from pathlib import Path

from rig import load_protocol, run

PROTOCOL = """\
schema: rig/protocol/1
name: drives
scene: {grains: {diameter: 8 mm, fill: 90 %}, layers: {rows: 2}}
drive: {acceleration: 3 m/s^2}
acquire: {settle: 5 cycles, record: 10 cycles}
repeats: 2
"""

for mode in ("prescribed", "shaker"):
    report = run(
        load_protocol(PROTOCOL, sets=[f"drive.mode={mode}"]),
        Path("sessions") / mode,
        overwrite=True,
    )
    (row,) = report.conditions
    distortion = f"THD of the acceleration {row.thd_acceleration:.0%}"
    print(
        f"{mode}: W_exp = {1e3 * row.W_exp:.1f} mJ per cycle at {row.acceleration:.2f} m/s^2, {distortion}"
    )
