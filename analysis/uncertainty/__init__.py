"""Estimates, budgets, and the statistics behind them."""
