"""Estimates, uncertainty budgets, and the statistics that they rest on."""
