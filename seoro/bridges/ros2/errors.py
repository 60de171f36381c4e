"""Errors between seoro and a ROS 2 system.

UsageError
|-- WrongType           a topic or service has another type than expected
`-- DefinitionMismatch  the type has the expected name, and another definition
BackendError
|-- NoSystem            no ROS 2 system was found
|-- CallFailed          a service call has no response
|   |-- NoServiceServer     the service has no server
|   |-- NoResponse          the server took too long, or disappeared
|   `-- ServerFailed        the server reported a failure
|-- GoalRejected        the server of an action rejected a goal
`-- NodeRefused         a node is missing, or rejected a request
BackendLost
`-- SystemLost          the connection to the ROS 2 system is lost
"""

from __future__ import annotations

from seoro.errors import BackendError, BackendLost, UsageError


class WrongType(UsageError):
    """A topic or service has another type than expected."""


class DefinitionMismatch(UsageError):
    """A robot and seoro have different definitions of the type of a topic or service.

    Args:
        name: Topic or service.
        type_name: Name of the type on both sides.
        theirs: Type hash of the robot.
        ours: Type hash of seoro.
    """

    def __init__(self, name: str, type_name: str, theirs: str, ours: str) -> None:
        super().__init__(
            f"{name}: the robot and seoro have different definitions of {type_name} "
            f"(robot {theirs}, seoro {ours})",
            help=f"give seoro the robot's own files of the package {type_name.partition('/')[0]}",
        )
        self.theirs = theirs
        self.ours = ours


class NoSystem(BackendError):
    """No ROS 2 system was found."""


class CallFailed(BackendError):
    """A service call has no response."""


class NoServiceServer(CallFailed):
    """The service has no server."""


class NoResponse(CallFailed):
    """The server took too long, or disappeared before it responded."""


class ServerFailed(CallFailed):
    """The server reported a failure instead of a response."""


class GoalRejected(BackendError):
    """The server of an action rejected a goal."""


class NodeRefused(BackendError):
    """A node is missing, lacks a parameter or a life cycle, or rejected a value."""


class SystemLost(BackendLost):
    """The connection to the ROS 2 system is lost; its nodes may be fine."""
