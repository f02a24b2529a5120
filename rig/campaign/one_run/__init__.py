"""The road of one run: its start, its record, and deliberate errors in it."""
