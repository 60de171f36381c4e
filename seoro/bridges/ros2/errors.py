"""What can go wrong between seoro and a ROS 2 system.

InvalidUse
|-- WrongType           a topic or service is of another type than the one that was asked for
`-- DefinitionMismatch  the types are called the same and are defined differently
BackendError
|-- NoSystem            no ROS 2 system is seen
`-- CallFailed          a call of a service had no response
    |-- NoServiceServer     nobody serves it
    |-- NoResponse          the server took too long, or went away
    `-- ServerFailed        the server said that it could not respond
BackendLost
`-- SystemLost          the connection to the ROS 2 system is lost
"""

from __future__ import annotations

from seoro.errors import BackendError, BackendLost, InvalidUse


class WrongType(InvalidUse):
    """A topic or service is of another type than the one that was asked for."""


class DefinitionMismatch(InvalidUse):
    """A robot and seoro have different definitions of the type of a topic or service.

    Args:
        name: The topic or service.
        type_name: What the type is called on both sides.
        theirs: The hash that the robot has of it.
        ours: The hash of the definition that seoro has.
    """

    def __init__(self, name: str, type_name: str, theirs: str, ours: str) -> None:
        super().__init__(
            f"{name}: the robot's definition of {type_name} is not the one here (theirs {theirs}, ours {ours})",
            help=f"give seoro the robot's own files of the package {type_name.partition('/')[0]}",
        )
        self.theirs = theirs
        self.ours = ours


class NoSystem(BackendError):
    """No ROS 2 system is seen."""


class CallFailed(BackendError):
    """A call of a service had no response."""


class NoServiceServer(CallFailed):
    """Nobody serves it."""


class NoResponse(CallFailed):
    """The server took too long, or went away while it had the request."""


class ServerFailed(CallFailed):
    """The server said that it could not respond."""


class SystemLost(BackendLost):
    """The connection to the ROS 2 system is lost: that nobody responds is no verdict on its nodes."""
