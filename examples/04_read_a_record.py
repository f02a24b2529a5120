"""The records of a session: samples in units, and the energy per cycle by hand and by the package."""

from pathlib import Path

import numpy as np

from analysis import run_energy
from daq import open_session
from rig import load_protocol, run

FREQUENCY = 20.0  # Hz, the protocol's default
folder = Path("sessions/record")
run(load_protocol("schema: rig/protocol/1\nname: record\nrepeats: 1\n"), folder, overwrite=True)

with open_session(folder / "session.h5") as record:
    first = record.runs[0]
    force, acceleration = (record.signal(first.name, name) for name in ("force", "acceleration"))
    found = run_energy(record, first.name)

per_cycle = round(force.rate / FREQUENCY)
cycles = (
    len(force.samples) // per_cycle - 12
)  # less the ten cycles of settling, and what the filters need
F, a = (
    signal.samples[11 * per_cycle : (11 + cycles) * per_cycle] for signal in (force, acceleration)
)
omega = 2 * np.pi * np.fft.rfftfreq(a.size, 1 / force.rate)
spectrum = np.fft.rfft(a)
spectrum[0], omega[0] = 0.0, 1.0  # the mean is no motion
velocity = np.fft.irfft(spectrum / (1j * omega))
print(
    f"{force.samples.size} samples of force in {force.unit} at {force.rate:g} S/s, {cycles} cycles used"
)
print(
    f"by hand: {1e3 * np.mean(F * velocity) / FREQUENCY:.2f} mJ per cycle, no pole and no skew corrected"
)
print(f"run_energy: {1e3 * found.energy.W:.2f} mJ per cycle")
