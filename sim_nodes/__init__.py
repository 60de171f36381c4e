"""Simulator nodes: processes that simulate worlds with robots, and serve them over Zenoh.

`python -m sim_nodes mujoco` starts one. Of seoro they know what is said on the wire, and nothing else.
"""
