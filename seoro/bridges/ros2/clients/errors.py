"""Rejections by nodes.

BackendError
|-- GoalRejected    the server of an action rejected a goal
`-- NodeRefused     a node is missing, or rejected a request
"""

from __future__ import annotations

from seoro.errors import BackendError


class GoalRejected(BackendError):
    """The server of an action rejected a goal."""


class NodeRefused(BackendError):
    """A node is missing, lacks a parameter or a life cycle, or rejected a value."""
