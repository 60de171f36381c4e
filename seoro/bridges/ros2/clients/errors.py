"""What those say who were asked for something.

BackendError
|-- GoalRejected    the server of an action does not take a goal
`-- NodeRefused     a node does not take a parameter, or has no such thing
"""

from __future__ import annotations

from seoro.errors import BackendError


class GoalRejected(BackendError):
    """The server of an action does not take a goal."""


class NodeRefused(BackendError):
    """A node does not take a parameter, or has no such thing."""
