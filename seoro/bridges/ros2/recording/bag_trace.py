"""Traces made from bags, for reports and recordings.

A bag that seoro made from a trace contains its records. Those of other bags are made from standard messages:
frames, scans, maps, plans and logs. They have no behaviors, and no verdict.
"""

from __future__ import annotations

import base64
import json
import math
import zlib
from collections.abc import Callable, Iterator, Mapping
from datetime import UTC, datetime
from typing import Any, Final

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.interfaces.errors import InvalidPayload, UnknownInterface
from seoro.bridges.ros2.recording.metadata import BagMessage
from seoro.bridges.ros2.recording.reader import Bag
from seoro.bridges.ros2.tf.robots import (
    ODOMETRY,
    TRANSFORMS,
    UNNAMED,
    PlacedRobot,
    RobotFrames,
    home_of,
    namespace_of,
)

Record = dict[str, Any]

TRACE: Final = "/trace"  # of bags that seoro made from traces
_SECOND: Final = 1_000_000_000  # [ns]
_POSES: Final = _SECOND // 10  # [ns] between two samples of a robot
_SCANS: Final = _SECOND // 2  # [ns] between two scans of a sensor
_DIGITS: Final = 4  # of poses, after the decimal point
_LEVELS: Final = {10: "debug", 20: "info", 30: "warning", 40: "error", 50: "error"}
_STRING: Final = "std_msgs/msg/String"
_UNKNOWN: Final = 255  # cell of a map


def records_of(bag: Bag) -> Iterator[Record]:
    """Yield the records of a trace.

    Args:
        bag: The bag.

    Raises:
        UnreadableBag: A file is damaged.
        InvalidPayload: A message is invalid.
    """
    types = TypeStore.bundled()
    topic = bag.topics.get(TRACE)
    if topic is not None and topic.type == _STRING:
        for message in bag.messages([TRACE]):
            yield json.loads(types.decode(_STRING, message.payload).data)
        return
    yield from _BagTrace(bag, types).records()


class _BagTrace:
    """Reader of a bag.

    Args:
        bag: The bag.
        types: Definitions of its types.
    """

    def __init__(self, bag: Bag, types: TypeStore) -> None:
        self._bag = bag
        self._types = types
        self._count = 0
        self._frames: dict[str, RobotFrames] = {}  # by namespace
        tf = [topic for topic in bag.topics.values() if topic.type == TRANSFORMS]
        self._namespaces = {namespace_of(topic.name) for topic in tf}
        self._robots: dict[str, str] = {}  # frames of their poses, by name
        self._has_map = False
        self._poses: dict[str, list[float]] = {}
        self._due: dict[str, int] = {}  # times of the next samples, by robot or topic [ns]
        self._notes: list[str] = []
        self._readers: Mapping[str, Callable[[str, Any, int], Iterator[Record]]] = {
            TRANSFORMS: self._transforms,
            ODOMETRY: self._odometry,
            "sensor_msgs/msg/LaserScan": self._scan,
            "nav_msgs/msg/OccupancyGrid": self._map,
            "nav_msgs/msg/Path": self._path,
            "rcl_interfaces/msg/Log": self._log,
        }

    def records(self) -> Iterator[Record]:
        """Yield the records."""
        begin = self._bag.extent.start
        name = self._bag.path.stem
        file = self._bag.path.name
        yield self._record("run.start", begin, {"scenario": name, "file": file, "clock": "real", "bag": file})
        known = [topic.name for topic in self._bag.topics.values() if topic.type in self._readers]
        for message in self._bag.messages(known):
            yield from self._read(message)

    def _read(self, message: BagMessage) -> Iterator[Record]:
        type_ = self._bag.topics[message.topic].type
        try:
            decoded = self._types.decode(type_, message.payload)
        except (InvalidPayload, UnknownInterface) as error:
            note = f"{message.topic}: {error}"
            if note not in self._notes:
                self._notes.append(note)
                yield self._record("log", message.received, {"level": "warning", "message": note})
            return
        yield from self._readers[type_](message.topic, decoded, message.received)

    def _transforms(self, topic: str, message: Any, at: int) -> Iterator[Record]:
        frames = self._frames_of(topic)
        frames.put_transforms(message, is_static=topic.endswith("/tf_static"))
        yield from self._sample(frames, at)

    def _odometry(self, topic: str, message: Any, at: int) -> Iterator[Record]:
        if topic.rpartition("/")[2] != "odom":
            return
        frames = self._frames_of(topic)
        frames.put_odometry(message)
        yield from self._sample(frames, at)

    def _frames_of(self, topic: str) -> RobotFrames:
        namespace = self._home(topic)
        return self._frames.setdefault(namespace, RobotFrames(namespace))

    def _home(self, topic: str) -> str:
        return home_of(topic, self._namespaces)

    def _sample(self, frames: RobotFrames, at: int) -> Iterator[Record]:
        for robot in frames.robots():
            name = robot.name
            if at < self._due.get(name, 0):
                continue
            self._due[name] = at + _POSES
            if self._robots.get(name) != robot.frame:
                self._robots[name] = robot.frame
                yield self._timed("entity", at, {"entity": _entity(robot)})
            pose = [round(value, _DIGITS) + 0.0 for value in (*robot.pose.translation, *robot.pose.rotation)]
            if self._poses.get(name) != pose:
                self._poses[name] = pose
                yield self._timed("poses", at, {"entities": {name: pose}})

    def _scan(self, topic: str, message: Any, at: int) -> Iterator[Record]:
        frames = self._frames.get(self._home(topic))
        if frames is None or at < self._due.get(topic, 0):
            return
        for robot in frames.robots():
            placed = frames.mount(message.header.frame_id, robot.base)
            if placed is None or robot.name not in self._robots:
                continue
            self._due[topic] = at + _SCANS
            ranges = [float(value) for value in message.ranges]
            fields = {
                "entity": robot.name,
                "sensor": topic.rpartition("/")[2],
                "pose": [*placed.translation, *placed.rotation],
                "angle_min": float(message.angle_min),
                "angle_increment": float(message.angle_increment),
                "ranges": [round(value, 3) if math.isfinite(value) else None for value in ranges],
            }
            yield self._timed("scan", at, fields)

    def _map(self, topic: str, message: Any, at: int) -> Iterator[Record]:
        if topic.rpartition("/")[2] != "map" or self._has_map:
            return
        self._has_map = True
        info, origin = message.info, message.info.origin
        yaw = 2.0 * math.atan2(origin.orientation.z, origin.orientation.w)
        cells = bytes(_UNKNOWN if cell < 0 else int(cell) for cell in message.data)
        grid = {
            "resolution": float(info.resolution),
            "origin": [origin.position.x, origin.position.y, yaw],
            "width": info.width,
            "height": info.height,
            "data": base64.b64encode(zlib.compress(cells)).decode(),
        }
        yield self._timed("scene", at, {"world": topic, "shapes": [], "entities": [], "map": grid})

    def _path(self, topic: str, message: Any, at: int) -> Iterator[Record]:
        if at < self._due.get(topic, 0):
            return
        self._due[topic] = at + _SECOND
        robot = self._home(topic) or UNNAMED
        if robot in self._robots:
            points = [[stamped.pose.position.x, stamped.pose.position.y] for stamped in message.poses]
            yield self._timed("path", at, {"entity": robot, "points": points})

    def _log(self, _: str, message: Any, at: int) -> Iterator[Record]:
        text = f"{message.name}: {message.msg}"
        yield self._record("log", at, {"level": _LEVELS.get(message.level, "info"), "message": text})

    def _timed(self, kind: str, at: int, fields: Record) -> Record:
        return self._record(kind, at, {"time": self._time(at), **fields})

    def _record(self, kind: str, at: int, fields: Record) -> Record:
        wall = datetime.fromtimestamp(at / _SECOND, UTC).isoformat()
        record = {"seq": self._count, "t": self._time(at), "wall": wall, "kind": kind, **fields}
        self._count += 1
        return record

    def _time(self, at: int) -> float:
        """Return a time since the start of the bag [s]."""
        return round((at - self._bag.extent.start) / _SECOND, 6)


def _entity(robot: PlacedRobot) -> Record:
    entity = {"name": robot.name, "kind": "robot", "real": True, "shapes": []}
    return entity if robot.frame == "map" else {**entity, "frame": robot.frame}
