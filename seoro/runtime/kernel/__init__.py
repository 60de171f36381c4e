"""The kernel: tasks, task groups, cancel scopes, channels and timers on one clock.

It knows nothing of plans, values and traces, and imports nothing of seoro.
"""
