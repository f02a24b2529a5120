"""Names of the numbers that a run ends with, beside its use of the exciter's limits."""

STOPS = ("force", "current", "voltage", "stroke", "jump", "time")
"""What can keep a level from being reached: a limit of the exciter, a level that no command keeps, patience."""

LEVEL_SCALARS = ("level_cycles", "level_jumps", "clipped", *(f"stopped_by_{name}" for name in STOPS))
"""With the exciter in the loop: cycles that the level control took, jumps of the level on the way, fraction of the held
cycles in which the amplifier was at a limit, and 1 for what stopped the level, 0 otherwise."""

RECORDED_SCALARS = ("W_T_recorded", "W_f_recorded", "u_W_T_recorded")
"""The prediction on the recorded waveform, J per cycle: with the start of the run's own drive (`predict_on_record`),
and what the bed's history leaves open as a standard uncertainty, the difference to the other start being the width of a
rectangular distribution."""

TRIGGER_SCALARS = ("trigger_sample",)
"""Samples from a start of the drive's cycle to the record's first sample."""
