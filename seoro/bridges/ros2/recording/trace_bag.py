"""Bags made from traces: a run in standard messages, for rviz and other tools of ROS 2."""

from __future__ import annotations

import base64
import json
import math
import re
import shutil
import zlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.recording.bag_values import (
    MAP,
    Values,
    pose_value,
    stamped,
    time_value,
    transform_value,
    vector,
)
from seoro.bridges.ros2.recording.errors import RefusedRecording
from seoro.bridges.ros2.recording.markers import WORLD, deletion, link_frame, markers_of
from seoro.bridges.ros2.recording.mcap_file import McapFile
from seoro.bridges.ros2.recording.metadata import BagMessage, BagTopic, write_metadata
from seoro.bridges.ros2.wire.qos import Durability, Qos
from seoro.robotics.transform import Transform, rotate
from seoro.traces.reader import wall_time

Record = Mapping[str, Any]

_SECOND: Final = 1_000_000_000  # [ns]
_LATCHED: Final = Qos(durability=Durability.TRANSIENT_LOCAL)
_MOVING: Final = Qos(depth=100)
_UNFIT: Final = re.compile(r"[^A-Za-z0-9_]")
_LEVELS: Final = {"debug": 10, "info": 20, "warning": 30, "error": 40}
_UNKNOWN_CELL: Final = 255
_ORIGIN: Final = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
FILM: Final = "/video/compressed"  # by the rule of image_transport, so that rviz finds it


def write_trace_bag(records: Iterable[Record], folder: Path, film: Iterable[tuple[float, bytes]] = ()) -> None:
    """Write a run as a bag.

    Args:
        records: Records of its trace, or a part of them.
        folder: Folder of the bag, which must not exist.
        film: Pictures of the whole run in JPEG, with their times [s].

    Raises:
        RefusedRecording: The folder exists.
        OSError: A file cannot be written.
        ValueError: A record is invalid; no bag is written.
    """
    if folder.exists():
        raise RefusedRecording(f"{folder} exists; expected a new folder")
    partial = folder.with_name(f".{folder.name}.partial")
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir(parents=True)
    try:
        mcap = McapFile(partial / f"{folder.name}_0.mcap", "zstd")
        bag = _TraceBag(mcap)
        try:
            for record in records:
                bag.add(record)
            bag.add_film(film)
        except BaseException:
            mcap.abandon()
            raise
        mcap.finish({})
        write_metadata(partial, mcap.information({}))
        partial.rename(folder)
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise


class _TraceBag:
    """Writer of the messages of a run."""

    def __init__(self, mcap: McapFile) -> None:
        self._mcap = mcap
        self._types = TypeStore.bundled()
        self._topics: set[str] = set()
        self._start: int | None = None  # of the run, since the epoch [ns]
        self._marker_counts: dict[str, int] = {}  # by entity
        self._by_odometry: set[str] = set()  # robots without a pose in the map

    def add(self, record: Record) -> None:
        """Write the messages of a record.

        Raises:
            ValueError: The record is invalid.
        """
        if self._start is None:  # of a part of a trace, too
            self._start = round((wall_time(record) - record["t"]) * _SECOND)
        at = self._start + round(record["t"] * _SECOND)
        self._write("/trace", "std_msgs/msg/String", {"data": json.dumps(record)}, at)
        at = self._start + round(record.get("time", record["t"]) * _SECOND)
        try:
            self._add(record, at)
        except (KeyError, TypeError, IndexError, ValueError, zlib.error) as error:
            raise ValueError(f"invalid record {record.get('seq')} (`{record['kind']}`): {error}") from error

    def add_film(self, film: Iterable[tuple[float, bytes]]) -> None:
        """Write pictures in JPEG, with their times since the start of the run [s]."""
        for time, data in film:
            assert self._start is not None, "a trace has a record"
            at = self._start + round(time * _SECOND)
            message = stamped(at, MAP) | {"format": "jpeg", "data": data}
            self._write(FILM, "sensor_msgs/msg/CompressedImage", message, at)

    def _add(self, record: Record, at: int) -> None:
        match record["kind"]:
            case "log":
                self._log(record["message"], _LEVELS.get(record["level"], 0), at)
            case "run.end":
                reason = f": {record['reason']}" if record["reason"] else ""
                self._log(f"{record['status']}{reason}", 20 if record["status"] == "passed" else 40, at)
            case "scene":
                self._scene(record, at)
            case "entity":
                self._entity(record["entity"], at)
            case "poses":
                self._poses(record, at)
            case "path":
                points = [
                    stamped(at, MAP) | {"pose": pose_value((x, y, 0, 0, 0, 0, 1))} for x, y in record["points"]
                ]
                message = stamped(at, MAP) | {"poses": points}
                self._write(f"/{_name(record['entity'])}/plan", "nav_msgs/msg/Path", message, at)
            case "scan":
                self._scan(record, at)

    def _log(self, text: str, level: int, at: int) -> None:
        message = {"stamp": time_value(at), "level": level, "name": "seoro", "msg": text}
        self._write("/rosout", "rcl_interfaces/msg/Log", message, at)

    def _scene(self, record: Record, at: int) -> None:
        frames = [
            frame
            for entity in record.get("entities", ())
            for frame in _link_transforms(at, entity["name"], entity.get("links", {}))
        ]
        self._transforms(frames, at)
        self._markers([{"name": WORLD, "shapes": record.get("shapes", ())}, *record.get("entities", ())], at)
        if (grid := record.get("map")) is not None:
            x, y, yaw = grid["origin"]
            size = {"resolution": grid["resolution"], "width": grid["width"], "height": grid["height"]}
            origin = pose_value((x, y, 0.0, 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)))
            cells = [
                -1 if cell == _UNKNOWN_CELL else cell for cell in zlib.decompress(base64.b64decode(grid["data"]))
            ]
            message = stamped(at, MAP) | {"info": size | {"origin": origin}, "data": cells}
            self._write("/map", "nav_msgs/msg/OccupancyGrid", message, at, _LATCHED)

    def _entity(self, entity: Record, at: int) -> None:
        name = entity["name"]
        if entity.get("frame", MAP) == MAP:
            self._by_odometry.discard(name)
        else:
            self._by_odometry.add(name)
        self._markers([entity], at)

    def _markers(self, entities: Sequence[Record], at: int) -> None:
        """Replace the markers of entities."""
        markers: list[Values] = []
        for entity in entities:
            name, found = entity["name"], list(markers_of(entity, at))
            known = self._marker_counts.pop(name, 0)
            markers += (deletion(name, number, at) for number in range(len(found), known))
            markers += found
            self._marker_counts[name] = len(found)
        if markers:
            self._write("/markers", "visualization_msgs/msg/MarkerArray", {"markers": markers}, at, _LATCHED)

    def _poses(self, record: Record, at: int) -> None:
        frames: list[Values] = []
        for name, pose in record["entities"].items():
            parent = self._root(name)
            if parent != MAP:  # its place in the map is unknown; the origin stands for it
                frames.append(transform_value(at, MAP, parent, _ORIGIN))
            frames.append(transform_value(at, parent, name, pose))
        for name, (x, y, yaw) in record.get("believed", {}).items():
            believed = (x, y, 0.0, 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
            frames.append(transform_value(at, MAP, f"{name}_believed", believed))
        for robot, links in record.get("links", {}).items():
            frames += _link_transforms(at, robot, links)
        self._transforms(frames, at)
        for name, pose in record["entities"].items():
            if len(pose) > 7:
                message = _odometry(self._root(name), name, pose, at)
                self._write(f"/{_name(name)}/odom", "nav_msgs/msg/Odometry", message, at)
        if removed := record.get("removed"):
            self._markers([{"name": name} for name in removed], at)

    def _root(self, name: str) -> str:
        """Return the frame of the poses of an entity."""
        return f"{name}/odom" if name in self._by_odometry else MAP

    def _transforms(self, frames: Sequence[Values], at: int) -> None:
        if frames:
            self._write("/tf", "tf2_msgs/msg/TFMessage", {"transforms": frames}, at, _MOVING)

    def _scan(self, record: Record, at: int) -> None:
        robot, sensor = record["entity"], record["sensor"]
        frame = f"{robot}/{sensor}"
        self._transforms([transform_value(at, robot, frame, record["pose"])], at)
        ranges = [math.inf if each is None else float(each) for each in record["ranges"]]
        first, step = record["angle_min"], record["angle_increment"]
        message = stamped(at, frame) | {
            "angle_min": first,
            "angle_max": first + step * max(0, len(ranges) - 1),
            "angle_increment": step,
            "range_max": record.get("range_max", math.inf),
            "ranges": ranges,
        }
        self._write(f"/{_name(robot)}/{_name(sensor)}", "sensor_msgs/msg/LaserScan", message, at)

    def _write(self, topic: str, type_: str, values: Values, at: int, qos: Qos = Qos()) -> None:  # noqa: B008 - frozen
        if topic not in self._topics:
            self._topics.add(topic)
            described = BagTopic(topic, type_, self._types.type_hash(type_), (qos,))
            self._mcap.add_topic(described, self._types.schema(type_))
        self._mcap.add_message(BagMessage(topic, self._types.encode(type_, values), at, at))


def _name(text: str) -> str:
    """Return a name for topics: letters, digits and underscores, no digit at the start."""
    found = _UNFIT.sub("_", text) or "_"
    return f"_{found}" if found[0].isdigit() else found


def _link_transforms(at: int, robot: str, links: Mapping[str, Sequence[float]]) -> list[Values]:
    return [transform_value(at, robot, link_frame(robot, link), pose) for link, pose in links.items()]


def _odometry(parent: str, name: str, pose: Sequence[float], at: int) -> Values:
    """Return the odometry of a body; velocities are in its own frame, as ROS has them."""
    x, y, z, qx, qy, qz, qw, vx, vy, vz, wx, wy, wz = pose
    turn = Transform((x, y, z), (qx, qy, qz, qw)).inverse().rotation
    linear, angular = rotate(turn, (vx, vy, vz)), rotate(turn, (wx, wy, wz))
    twist = {"linear": vector(*linear), "angular": vector(*angular)}
    message = {"child_frame_id": name, "pose": {"pose": pose_value(pose)}, "twist": {"twist": twist}}
    return stamped(at, parent) | message
