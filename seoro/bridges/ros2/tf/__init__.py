"""Transforms between frames, from `/tf` and `/tf_static`.

`TransformBuffer` does no I/O; `listener.listen` fills one from a ROS 2 system.
"""

from seoro.bridges.ros2.tf.buffer import Stamped, TransformBuffer
from seoro.bridges.ros2.tf.errors import FramesNotConnected, OutOfReach, TransformError, UnknownFrame
from seoro.robotics.transform import IDENTITY, Transform

__all__ = [
    "IDENTITY",
    "FramesNotConnected",
    "OutOfReach",
    "Stamped",
    "Transform",
    "TransformBuffer",
    "TransformError",
    "UnknownFrame",
]
