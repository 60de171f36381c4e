"""Checks of the installation, and of each hop from here to executors, labs and robots. Nothing here prints.

`findings.py` has the results of checks. `installation.py` checks this machine, `endpoint.py` sockets. `path.py`
checks the path to executors. `lab.py` checks the paths to a lab, from here and from executors. `peers.py`
and `nodes.py` make the findings about executors, nodes and robots.
"""
