"""Sweeps: runs of a scenario for all combinations of listed values of parameters."""
