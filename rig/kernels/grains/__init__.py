"""Resolved grains: soft spheres with rotation in a box, one compiled time loop."""
