"""Preflight of a campaign: limits, ranges, and the decisions that its repeats will allow."""
