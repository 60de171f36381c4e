"""Debugging of runs on virtual and simulated clocks: pauses, steps, breakpoints, and what a paused run does.

`Debugger` controls a run, `DebugClock` stops its time, and `inspection` describes its tasks and variables.
"""
