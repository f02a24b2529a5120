"""Compiled loops for rows of grains: alone, together, on a recorded motion, on an exciter."""
