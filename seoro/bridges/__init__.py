"""Connections over Zenoh: backends of the runtime, executors, and the servers of nodes.

`session` wraps Zenoh, `wire` defines the messages. `sim`, `robot` and `ros2` are backends, `launch` starts
simulators, `executor` has the client of executors, and `serving` and `leasing` the common parts of nodes.
"""
