"""Simulator nodes as backends of the runtime, which they serve by requests over the wire.

`Requests` sends requests and passes on events; each capability of a node is a subclass of it. `SimulatorNode`
unites them all. May import the session, the wire and the runtime's contracts.
"""
