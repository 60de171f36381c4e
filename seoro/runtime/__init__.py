"""From plan to trace and verdict: the reactive runtime.

It knows plans, contracts and time; it knows no syntax and no middleware.
"""
