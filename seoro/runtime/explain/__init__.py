"""Explanations of verdicts: what a run waited for and executed at the deciding instant."""
