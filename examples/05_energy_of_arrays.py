"""Force and acceleration as arrays, from anywhere: a rigid mass on a dashpot, whose energy is
known: pi c w X^2.
"""

import numpy as np

from analysis import dissipated_energy

rate, frequency, level = 10240.0, 20.0, 5.0  # S/s, Hz, m/s^2
mass, dashpot = 30.0, 50.0  # kg, N s/m
omega = 2 * np.pi * frequency
t = np.arange(round(10 * rate / frequency)) / rate
acceleration = level * np.sin(omega * t)
velocity = -level / omega * np.cos(omega * t)

energy = dissipated_energy(mass * acceleration + dashpot * velocity, acceleration, rate, frequency)
exact = np.pi * dashpot * level**2 / omega**3
print(f"W = {energy.W:.9f} J per cycle, exactly {exact:.9f}; apparent mass {energy.M_eff:.6f} kg")
