"""Executors: they take scenarios over the network, run them one after the other or some at a time, and keep what
comes of them.

`store.py` keeps runs in SQLite and their files in folders, `blobs.py` the contents of bundles. `order.py` says
which run is next, `queue.py` sees to it until its end, `workers.py` gets a process for it, which `template.py`
makes and in which `worker.py` runs it; `frames.py` is what these say to each other. `policy.py` says what
scenarios must not do here. `serving.py` answers clients, and `running.py` puts it all together.
"""
