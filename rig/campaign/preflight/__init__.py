"""A campaign before it is run: limits, ranges, and what its repeats will be able to decide."""
