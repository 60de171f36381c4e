"""Executors: they take scenarios over the network, run them one after the other or some at a time, and keep what
comes of them.

`store.py` keeps runs in SQLite and their files in folders, `blobs.py` the contents of bundles. `queue.py` says
which run is next and sees to it until its end, `workers.py` has a process ready for it, in which `worker.py`
runs it; `frames.py` is what the two say to each other. `policy.py` says what a scenario must not do here.
`serving.py` answers clients, and `running.py` puts it all together.
"""
