"""Names of the final scalars of a run, except the utilisation of the exciter's limits."""

STOPS = ("force", "current", "voltage", "stroke", "jump", "time")
"""Reasons for not reaching a level: a limit of the exciter, a level that no command
holds, timeout.
"""

LEVEL_SCALARS = (
    "level_cycles",
    "level_jumps",
    "clipped",
    *(f"stopped_by_{name}" for name in STOPS),
)
"""Shaker-coupled drive: cycles of the level control; jumps of the level on the way; fraction
of the held cycles in which the amplifier was at a limit; and for each reason 1 if it stopped the
level, 0 otherwise.
"""

RECORDED_SCALARS = ("W_T_recorded", "W_f_recorded", "u_W_T_recorded")
"""The prediction on the recorded waveform, J per cycle, with the start of the run's own drive
(`predict_on_record`), and its standard uncertainty due to the bed's history: the difference to the
other start is taken as the width of a rectangular distribution.
"""

TRIGGER_SCALARS = ("trigger_sample",)
"""Samples from a start of the drive's cycle to the record's first sample."""
