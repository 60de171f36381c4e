"""Nodes and endpoints of a ROS 2 system, as announced by liveliness tokens."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from seoro.bridges.ros2.wire.qos import Qos


class Kind(Enum):
    """Kind of an endpoint; the values are the codes of both dialects."""

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
        session: Zenoh ID of the session of the node.
        number: Number of the node in its session.
        name: Name without the namespace.
        namespace: Absolute namespace.
        enclave: Absolute name of the security enclave; `/` without security.
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
        name: Full name of the topic, service or action.
        type: Type, such as `std_msgs/msg/String`; the announced text if it is not a ROS 2 type.
        type_hash: Hash of the type definition; None if it was not announced.
        qos: QoS profile; None if it was not announced, or is invalid.
        session: Zenoh ID of the session of the endpoint; behind a bridge, that of the bridge.
        number: Number of the endpoint in its session; None behind a bridge.
        node: Node of the endpoint; None behind a bridge, which announces no nodes.
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
