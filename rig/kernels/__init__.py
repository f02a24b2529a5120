"""Compiled loops: arithmetic only, no physical decision."""
