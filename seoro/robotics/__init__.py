"""Poses, velocities and faults of robots, which contracts of the runtime and messages of nodes share.

The classes are frozen dataclasses. They are fields of messages and arguments of contracts. This package
imports nothing of seoro.
"""
