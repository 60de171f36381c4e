"""Robots of bridges as a backend of the runtime, in real time.

`connecting` acquires robots of a bridge for a run, `RobotNode` implements the runtime's contracts by requests
to it. May import the session, the wire and `seoro.bridges.sim`.
"""
