"""Language server: answers requests of editors about scenario files over the Language Server Protocol.

`features.py` has the requests, `server.py` the state, `scheduling.py` schedules checks, and `analysis.py` runs
them. The other modules answer one kind of request from an `Analysis`, and do not import the server.
"""
