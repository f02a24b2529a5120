"""Results of runs and conditions, and the rows of the report."""
