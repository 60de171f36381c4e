"""Leases and holds of robots, and emergency stops: state and rules. The only I/O is the file of stops.

`leases.py` has holders, leases and the wait queue; `emergency_stop.py` the emergency stop; `event_filter.py`
selects the events of each run. Bridges (`seoro.bridges.serving`) and simulator nodes use it.
"""
