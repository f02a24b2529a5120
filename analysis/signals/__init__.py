"""Sampled signals: whole cycles, corrections, quality."""
