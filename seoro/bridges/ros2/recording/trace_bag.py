"""Bags made from traces: a run in standard messages, for rviz and other tools of ROS 2."""

from __future__ import annotations

import base64
import json
import math
import re
import shutil
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.recording.errors import RefusedRecording
from seoro.bridges.ros2.recording.mcap_file import McapFile
from seoro.bridges.ros2.recording.metadata import BagMessage, BagTopic, write_metadata
from seoro.bridges.ros2.wire.qos import Durability, Qos
from seoro.robotics.transform import Transform, rotate
from seoro.traces.reader import wall_time

Record = Mapping[str, Any]
Values = dict[str, Any]

_SECOND: Final = 1_000_000_000  # [ns]
_MAP: Final = "map"
_LATCHED: Final = Qos(durability=Durability.TRANSIENT_LOCAL)
_MOVING: Final = Qos(depth=100)
_UNFIT: Final = re.compile(r"[^A-Za-z0-9_]")
_LEVELS: Final = {"debug": 10, "info": 20, "warning": 30, "error": 40}
_MARKERS: Final = {"box": 1, "sphere": 2, "cylinder": 3, "capsule": 3}  # by the kind of a shape
_UNKNOWN_CELL: Final = 255
_GREY: Final = "#808080"


def write_trace_bag(records: Iterable[Record], folder: Path) -> None:
    """Write a run as a bag.

    Args:
        records: Records of its trace, or a part of them.
        folder: Folder of the bag, which must not exist.

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
                self._markers([record["entity"]], at)
            case "poses":
                self._poses(record, at)
            case "path":
                points = [_stamped(at, _MAP) | {"pose": _pose((x, y, 0, 0, 0, 0, 1))} for x, y in record["points"]]
                message = _stamped(at, _MAP) | {"poses": points}
                self._write(f"/{_name(record['entity'])}/plan", "nav_msgs/msg/Path", message, at)
            case "scan":
                self._scan(record, at)

    def _log(self, text: str, level: int, at: int) -> None:
        message = {"stamp": _time(at), "level": level, "name": "seoro", "msg": text}
        self._write("/rosout", "rcl_interfaces/msg/Log", message, at)

    def _scene(self, record: Record, at: int) -> None:
        shapes = [{"name": "world", "shapes": record.get("shapes", ())}]
        self._markers([*shapes, *record.get("entities", ())], at)
        if (grid := record.get("map")) is not None:
            x, y, yaw = grid["origin"]
            size = {"resolution": grid["resolution"], "width": grid["width"], "height": grid["height"]}
            origin = _pose((x, y, 0.0, 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)))
            cells = [
                -1 if cell == _UNKNOWN_CELL else cell for cell in zlib.decompress(base64.b64decode(grid["data"]))
            ]
            message = _stamped(at, _MAP) | {"info": size | {"origin": origin}, "data": cells}
            self._write("/map", "nav_msgs/msg/OccupancyGrid", message, at, _LATCHED)

    def _markers(self, entities: Sequence[Record], at: int) -> None:
        markers = [marker for entity in entities for marker in _markers_of(entity, at)]
        if markers:
            self._write("/markers", "visualization_msgs/msg/MarkerArray", {"markers": markers}, at, _LATCHED)

    def _poses(self, record: Record, at: int) -> None:
        frames = [_frame(at, _MAP, name, pose) for name, pose in record["entities"].items()]
        for name, (x, y, yaw) in record.get("believed", {}).items():
            believed = (x, y, 0.0, 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
            frames.append(_frame(at, _MAP, f"{name}_believed", believed))
        for robot, links in record.get("links", {}).items():
            frames += [_frame(at, robot, f"{robot}/{link}", pose) for link, pose in links.items()]
        if frames:
            self._write("/tf", "tf2_msgs/msg/TFMessage", {"transforms": frames}, at, _MOVING)
        for name, pose in record["entities"].items():
            if len(pose) > 7:
                message = _odometry(name, pose, at)
                self._write(f"/{_name(name)}/odom", "nav_msgs/msg/Odometry", message, at)

    def _scan(self, record: Record, at: int) -> None:
        robot, sensor = record["entity"], record["sensor"]
        frame = f"{robot}/{sensor}"
        transforms = {"transforms": [_frame(at, robot, frame, record["pose"])]}
        self._write("/tf", "tf2_msgs/msg/TFMessage", transforms, at, _MOVING)
        ranges = [math.inf if each is None else float(each) for each in record["ranges"]]
        first, step = record["angle_min"], record["angle_increment"]
        message = _stamped(at, frame) | {
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


def _time(at: int) -> Values:
    return {"sec": at // _SECOND, "nanosec": at % _SECOND}


def _stamped(at: int, frame: str) -> Values:
    return {"header": {"stamp": _time(at), "frame_id": frame}}


def _vector(x: float, y: float, z: float) -> Values:
    return {"x": float(x), "y": float(y), "z": float(z)}


def _quaternion(values: Sequence[float]) -> Values:
    return dict(zip("xyzw", map(float, values), strict=True))


def _pose(values: Sequence[float]) -> Values:
    x, y, z, *rotation = values[:7]
    return {"position": _vector(x, y, z), "orientation": _quaternion(rotation)}


def _frame(at: int, parent: str, child: str, pose: Sequence[float]) -> Values:
    x, y, z, *rotation = pose[:7]
    transform = {"translation": _vector(x, y, z), "rotation": _quaternion(rotation)}
    return _stamped(at, parent) | {"child_frame_id": child, "transform": transform}


def _odometry(name: str, pose: Sequence[float], at: int) -> Values:
    """Return the odometry of a body; velocities are in its own frame, as ROS has them."""
    x, y, z, qx, qy, qz, qw, vx, vy, vz, wx, wy, wz = pose
    turn = Transform((x, y, z), (qx, qy, qz, qw)).inverse().rotation
    linear, angular = rotate(turn, (vx, vy, vz)), rotate(turn, (wx, wy, wz))
    twist = {"linear": _vector(*linear), "angular": _vector(*angular)}
    message = {"child_frame_id": name, "pose": {"pose": _pose(pose)}, "twist": {"twist": twist}}
    return _stamped(at, _MAP) | message


def _markers_of(entity: Record, at: int) -> Iterator[Values]:
    """Yield the shapes of an entity in its frame, those of the world in `map`, without hulls and prisms."""
    is_world = entity["name"] == "world"
    for number, shape in enumerate(entity.get("shapes", ())):
        kind = _MARKERS.get(shape["kind"])
        if kind is None:
            continue
        size = shape["size"]
        if shape["kind"] == "box":
            scale = size
        else:
            radius, *length = size
            scale = (2 * radius, 2 * radius, length[0] if length else 2 * radius)
        link = f"{entity['name']}/{shape['link']}" if shape.get("link") else entity["name"]
        color = [int(shape.get("color", _GREY)[place : place + 2], 16) / 255 for place in (1, 3, 5)]
        yield _stamped(at, _MAP if is_world else link) | {
            "ns": entity["name"],
            "id": number,
            "type": kind,
            "pose": _pose(shape["pose"]),
            "scale": _vector(*scale),
            "color": dict(zip("rgba", (*color, 1.0), strict=True)),
            "frame_locked": not is_world,
        }
