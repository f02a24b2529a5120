"""The programmed motion, and the exciter that has to produce it."""
