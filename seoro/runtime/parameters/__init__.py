"""Values for the parameters of new instances and of their modifiers.

It imports `choose`, `expressions` and `instances`.
"""
