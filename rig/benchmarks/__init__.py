"""Measurements of speed, error and stability, each a command: `rig bench`, `make stability`."""
