"""Strategies: which values the runs of a campaign get."""
