"""Resolved grains in a shaken box: against the engine table, and what prediction `column` says."""
