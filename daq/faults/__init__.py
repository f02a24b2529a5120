"""Faults put in on purpose: before the transducers, or in the blocks."""
