"""Deliberate faults: in the sources ahead of the transducers, or in the blocks of codes."""
