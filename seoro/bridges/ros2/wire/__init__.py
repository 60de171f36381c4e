"""Mapping of ROS 2 to Zenoh: names, QoS, keys, tokens and attachments. Pure data and functions.

ROS 2 systems use Zenoh in two dialects (`Dialect`): `RmwZenoh` is the middleware rmw_zenoh, `Ros2Dds` the bridge
of robots that use DDS.
"""

from seoro.bridges.ros2.wire.attachment import Attachment
from seoro.bridges.ros2.wire.dialects import Dialect, named_dialect
from seoro.bridges.ros2.wire.entities import Endpoint, Entity, Kind, Node
from seoro.bridges.ros2.wire.names import InvalidName, check_node_name, is_hidden, resolve, resolve_namespace
from seoro.bridges.ros2.wire.qos import LATCHED, PRESETS, Durability, History, Liveliness, Qos, Reliability
from seoro.bridges.ros2.wire.rmw_zenoh import RmwZenoh
from seoro.bridges.ros2.wire.ros2dds import Ros2Dds

__all__ = [
    "LATCHED",
    "PRESETS",
    "Attachment",
    "Dialect",
    "Durability",
    "Endpoint",
    "Entity",
    "History",
    "InvalidName",
    "Kind",
    "Liveliness",
    "Node",
    "Qos",
    "Reliability",
    "RmwZenoh",
    "Ros2Dds",
    "check_node_name",
    "is_hidden",
    "named_dialect",
    "resolve",
    "resolve_namespace",
]
