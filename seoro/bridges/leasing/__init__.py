"""Who has which robots of a node, and whether anything may move: data and rules, without I/O but a file.

`leases.py` has holders, leases by hand and who waits; `latch.py` the emergency stop; `share.py` says what of all
that has happened is whose. Bridges (`seoro.bridges.serving`) and simulator nodes put it to work, each in its way.
"""
