"""The prescribed motion, level control, and the exciter that has to produce the motion."""
