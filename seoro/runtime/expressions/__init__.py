"""Evaluation of the plan's expressions. It imports values, functions, and `choose` to construct structs."""
