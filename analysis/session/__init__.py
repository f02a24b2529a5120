"""Interface to a recorded session: its runs and channels, its settings, its documents."""
