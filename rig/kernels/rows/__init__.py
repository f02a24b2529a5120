"""Compiled rows of grains: alone, together, on a recorded motion, on an exciter."""
