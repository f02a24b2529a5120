"""Grains on LAMMPS, in a process of its own: for beds that outgrow a machine, and to check ours."""
