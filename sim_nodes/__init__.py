"""Simulator nodes: processes that simulate worlds with robots and serve them over Zenoh.

`python -m sim_nodes mujoco` starts one. Of seoro, nodes import the wire protocol and Zenoh sessions.
"""
