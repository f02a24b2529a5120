"""A run and a condition, evaluated."""
