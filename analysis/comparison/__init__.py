"""Comparison of a session with its prediction: agreement, null tests, claims, verdict."""
