"""Robots of a ROS 2 system by their frames and odometry, for poses in traces."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import Any, Final, Literal

from seoro.bridges.ros2.tf.buffer import TransformBuffer
from seoro.bridges.ros2.tf.edges import SECOND
from seoro.robotics.transform import IDENTITY, Transform, normalised

TRANSFORMS: Final = "tf2_msgs/msg/TFMessage"
ODOMETRY: Final = "nav_msgs/msg/Odometry"
UNNAMED: Final = "robot"  # name of a robot without namespace and prefix
_MAP: Final = "map"
_ODOM: Final = "odom"
_BASES: Final = ("base_link", "base_footprint")

RootFrame = Literal["map", "odom"]


@dataclass(frozen=True, slots=True)
class PlacedRobot:
    """Latest known pose of the base of a robot.

    Attributes:
        name: Name of its namespace or frame prefix, else `robot`.
        base: Frame of its base.
        frame: Frame of the pose: `map`, or `odom` without a localisation.
        pose: The pose.
    """

    name: str
    base: str
    frame: RootFrame
    pose: Transform


class RobotFrames:
    """Frames of the robots in a namespace.

    The odometry counts for frames that no transform has.

    Args:
        namespace: Namespace of the topics; empty for the root.
        on_note: Called with invalid data, and when the time was set back.
    """

    def __init__(self, namespace: str, on_note: Callable[[str], None] = lambda text: None) -> None:
        self._namespace = namespace
        self._buffer = TransformBuffer(on_note=on_note)
        self._by_odometry: set[str] = set()  # frames without a transform

    def put_transforms(self, message: Any, *, is_static: bool) -> None:
        """Add a `tf2_msgs/msg/TFMessage`."""
        self._by_odometry -= {stamped.child_frame_id.removeprefix("/") for stamped in message.transforms}
        self._buffer.put_message(message, is_static=is_static)

    def put_odometry(self, message: Any) -> None:
        """Add a `nav_msgs/msg/Odometry`, unless transforms have its frame."""
        base = message.child_frame_id.removeprefix("/") or _BASES[0]
        if base not in self._by_odometry and base in self._buffer.parents:
            return
        place, turned = message.pose.pose.position, message.pose.pose.orientation
        rotation = normalised((turned.x, turned.y, turned.z, turned.w))
        if rotation is None:
            return
        self._by_odometry.add(base)
        stamp = message.header.stamp
        transform = Transform((place.x, place.y, place.z), rotation)
        self._buffer.put(_root(message.header.frame_id), base, transform, stamp.sec * SECOND + stamp.nanosec)

    @property
    def has_transforms(self) -> bool:
        """Whether transforms, not odometry alone, place a robot."""
        return any(base not in self._by_odometry for base in self._bases().values())

    def robots(self) -> Iterator[PlacedRobot]:
        """Yield the robots whose pose is known."""
        for name, base in self._bases().items():
            found = self._placed(base)
            if found is not None:
                frame, pose = found
                yield PlacedRobot(name, base, frame, pose)

    def mount(self, sensor: str, base: str) -> Transform | None:
        """Return the pose of a sensor in the frame of a base; None if it is unknown."""
        found = self._buffer.find(sensor, base)
        return None if found is None else found.transform

    def _bases(self) -> dict[str, str]:
        """Return the frames of the bases of robots, by their names."""
        found: dict[str, str] = {}
        for frame in self._buffer.frames:
            prefix, _, last = frame.rpartition("/")
            if last in _BASES:
                name = prefix or self._namespace or UNNAMED
                if found.get(name, "").rpartition("/")[2] != _BASES[0]:
                    found[name] = frame
        return found

    def _placed(self, base: str) -> tuple[RootFrame, Transform] | None:
        """Return the pose of a base in the map, or in the frame of its odometry.

        The latest transform of each frame counts: localisations may publish rarely.
        """
        parents, frame, transform = self._buffer.parents, base, IDENTITY
        seen: set[str] = {base}
        placed: tuple[RootFrame, Transform] | None = None
        while (parent := parents.get(frame)) is not None and parent not in seen:
            found = self._buffer.find(frame, parent)
            if found is None:
                break
            transform = found.transform @ transform
            frame = parent
            seen.add(frame)
            match frame.rpartition("/")[2]:
                case "map":
                    placed = ("map", transform)
                case "odom":
                    placed = ("odom", transform)
        return placed


def home_of(topic: str, namespaces: Collection[str]) -> str:
    """Return the namespace of the robot that has a topic.

    Args:
        topic: Name of the topic.
        namespaces: Namespaces with transforms, which robots have. Without one around the topic, it is its own.
    """
    own = namespace = namespace_of(topic)
    while namespace not in namespaces:
        if not namespace:
            return own
        namespace = namespace_of(namespace)
    return namespace


def namespace_of(name: str) -> str:
    """Return the namespace of a topic or namespace, without slashes at its ends; empty for the root."""
    return name.strip("/").rpartition("/")[0]


def _root(frame: str) -> str:
    """Return the frame of an odometry; names of other frames are replaced by `odom`."""
    frame = frame.removeprefix("/")
    return frame if frame.rpartition("/")[2] in (_MAP, _ODOM) else _ODOM
