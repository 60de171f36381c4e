"""Interfaces of ROS 2: their definitions, type hashes, and messages in CDR.

This package imports neither Zenoh nor asyncio. `TypeStore` is its main type. Numpy and rosbags are imported when
the first message is encoded or decoded.
"""

from seoro.bridges.ros2.interfaces.errors import InvalidDefinition, InvalidPayload, InvalidValue, UnknownInterface
from seoro.bridges.ros2.interfaces.messages import Message
from seoro.bridges.ros2.interfaces.store import TypeStore

__all__ = ["InvalidDefinition", "InvalidPayload", "InvalidValue", "Message", "TypeStore", "UnknownInterface"]
