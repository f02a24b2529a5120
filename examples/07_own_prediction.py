"""Measured against a prediction of your own: any W_T(a) as plain numbers takes the model's place."""

from pathlib import Path

from analysis import agreement, run_energy
from daq import open_session
from rig import load_protocol, run

PROTOCOL = "schema: rig/protocol/1\nname: levels\nvary: {drive.acceleration: [3 m/s^2, 4 m/s^2, 5 m/s^2]}\nrepeats: 3\n"
folder = Path("sessions/levels")
run(load_protocol(PROTOCOL), folder, overwrite=True)

levels = [2.9, 3.5, 4.0, 4.5, 5.2]  # m/s^2
mine = {
    "acceleration": levels,
    "W_T": [0.0017 * a**2.9 for a in levels],
    "u_rel": 0.05,
}  # J per cycle
with open_session(folder / "session.h5") as record:
    energies = [run_energy(record, item.name) for item in record.runs]
    prediction = {"conditions": dict.fromkeys(record.conditions, mine)}
    report = agreement(energies, record.conditions, prediction, record.channels)

for row in report.conditions:
    print(
        f"{row.acceleration:.2f} m/s^2: measured {1e3 * row.W_exp:.0f}, mine {1e3 * row.W_T:.0f} mJ"
    )
total = report.agreement
print(f"measured over mine: {total.ratio:.2f} +- {total.U_ratio:.2f}")
