"""Campaigns: their runs, where those are computed, recording and resuming. The only place that sees
all three packages.
"""
