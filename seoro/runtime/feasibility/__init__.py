"""Checks of invocations against the constraints of their declarations, without a run."""
