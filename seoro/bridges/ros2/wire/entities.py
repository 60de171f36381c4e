"""What a ROS 2 system consists of, as its liveliness tokens tell."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from seoro.bridges.ros2.wire.qos import Qos


class Kind(Enum):
    """Kinds of endpoints, by the letters that both dialects have for them."""

    PUBLISHER = "MP"
    SUBSCRIPTION = "MS"
    SERVER = "SS"
    CLIENT = "SC"
    ACTION_SERVER = "AS"
    ACTION_CLIENT = "AC"


@dataclass(frozen=True)
class Node:
    """A node.

    Attributes:
        session: Zenoh's id of the session that it is in.
        number: Tells the nodes of a session apart.
        namespace: Absolute.
        enclave: Of its security, absolute; `/` when there is none.
    """

    session: str
    number: int
    name: str
    namespace: str = "/"
    enclave: str = "/"

    @property
    def full_name(self) -> str:
        """Namespace and name."""
        return f"/{self.name}" if self.namespace == "/" else f"{self.namespace}/{self.name}"


@dataclass(frozen=True)
class Endpoint:
    """A publisher, a subscription, or the server or client of a service or an action.

    Attributes:
        name: Full name of its topic, service or action.
        type: `std_msgs/msg/String`, or what was announced if that names no type of ROS 2.
        type_hash: What the definition of the type amounts to; None where that is not told.
        qos: None where that is not told, or cannot be read.
        session: Zenoh's id of the session that it is in; behind a bridge, that of the bridge.
        number: Tells the endpoints of a session apart; None behind a bridge.
        node: The node that it belongs to; None behind a bridge, which tells of none.
    """

    kind: Kind
    name: str
    type: str
    session: str
    type_hash: str | None = None
    qos: Qos | None = None
    number: int | None = None
    node: Node | None = None


Entity = Node | Endpoint
