"""Hard cases: each provokes a failure, states the required behaviour, and measures it against
something independent.
"""
