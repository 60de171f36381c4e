"""Recordings in MCAP with Foxglove's schemas, made from the records of a trace."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any, Final

from foxglove import Channel, Context, Schema, open_mcap
from foxglove.channels import (
    CompressedVideoChannel,
    FrameTransformsChannel,
    GridChannel,
    LaserScanChannel,
    LogChannel,
    PosesInFrameChannel,
    SceneUpdateChannel,
)
from foxglove.messages import (
    CompressedVideo,
    FrameTransform,
    FrameTransforms,
    LaserScan,
    Log,
    LogLevel,
    Pose,
    PosesInFrame,
    Timestamp,
    Vector3,
)

from seoro.files.replacing import replacing
from seoro.traces.films import FORMAT, film_pictures
from seoro.traces.foxglove.scenes import (
    MAP,
    UPRIGHT,
    entity_update,
    grid_of,
    link_frame,
    removal_update,
    scene_update,
)
from seoro.traces.foxglove.values import SECOND, to_pose, to_quaternion, to_timestamp
from seoro.traces.reader import wall_time

LAYOUT: Final = "foxglove-layout.json"
FILM: Final = "/video"
_ORIGIN: Final = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
_ANY_OBJECT: Final = Schema(name="seoro.TraceRecord", encoding="jsonschema", data=b'{"type": "object"}')
_LEVELS: Final[Mapping[str, LogLevel]] = {
    "debug": LogLevel.Debug,
    "info": LogLevel.Info,
    "warning": LogLevel.Warning,
    "error": LogLevel.Error,
}

Record = dict[str, Any]


def write_recording(records: Iterable[Record], path: Path, film: Path | None = None) -> None:
    """Write a recording, and a layout for Foxglove beside it.

    Args:
        records: Records of a trace, or a part of them.
        path: The file; an existing one is replaced.
        film: Film of the whole run, in MP4; None for none.

    Raises:
        OSError: A file cannot be written.
        ValueError: A record or the film is invalid; no file is written.
    """
    context = Context()
    with replacing(path) as partial, open_mcap(partial, allow_overwrite=True, context=context):
        recording = _Recording(context)
        for record in records:
            recording.add(record)
        if film is not None:
            recording.add_film(film)
    path.with_name(LAYOUT).write_text(json.dumps(_layout(recording.topics, has_film=film is not None), indent=2))


def _layout(topics: Iterable[str], *, has_film: bool) -> dict[str, Any]:
    """Return the layout: the topics of robots are visible, and a film has a panel."""
    layout: dict[str, Any] = json.loads(resources.files(__package__).joinpath("layout.json").read_bytes())
    layout["configById"]["3D!seoro"]["topics"] |= {topic: {"visible": True} for topic in topics}
    if has_film:
        layout["configById"]["Image!seoro"] = {"imageMode": {"imageTopic": FILM}}
        world, others = layout["layout"]["first"], layout["layout"]["second"]
        panel = {"first": "Image!seoro", "second": others, "direction": "column", "splitPercentage": 40}
        layout["layout"] |= {"first": world, "second": panel}
    return layout


class _Recording:
    """Writer of the messages of a run."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._start: int | None = None  # of the run, since the epoch [ns]
        self._trace = Channel("/trace", message_encoding="json", schema=_ANY_OBJECT, context=context)
        self._log = LogChannel("/log", context=context)
        self._frames = FrameTransformsChannel("/tf", context=context)
        self._scene = SceneUpdateChannel("/scene", context=context)
        self._map = GridChannel("/map", context=context)
        self._paths: dict[str, PosesInFrameChannel] = {}
        self._scans: dict[str, LaserScanChannel] = {}
        self._by_odometry: set[str] = set()  # robots without a pose in the map

    def add(self, record: Record) -> None:
        """Write the messages of a record."""
        if self._start is None:  # of a part of a trace, too
            self._start = round((wall_time(record) - record["t"]) * SECOND)
        self._trace.log(json.dumps(record).encode(), log_time=self._at(record["t"]))
        time: float = record["time"] if "time" in record else record["t"]
        at = self._at(time)
        try:
            self._add(record, at, to_timestamp(at))
        except (KeyError, TypeError, IndexError, ValueError) as error:
            raise ValueError(f"invalid record {record.get('seq')} (`{record['kind']}`): {error}") from error

    def add_film(self, film: Path) -> None:
        """Write the pictures of a film that begins with the run."""
        channel = CompressedVideoChannel(FILM, context=self._context)
        for time, data in film_pictures(film):
            at = self._at(time)
            picture = CompressedVideo(timestamp=to_timestamp(at), frame_id=MAP, data=data, format=FORMAT)
            channel.log(picture, log_time=at)

    @property
    def topics(self) -> list[str]:
        """Topics of robots: plans and scans."""
        return [*(channel.topic() for channel in self._paths.values()), *self._scans]

    def _at(self, time: float) -> int:
        assert self._start is not None, "set by the first record"
        return self._start + round(time * SECOND)

    def _add(self, record: Record, at: int, stamp: Timestamp) -> None:
        match record["kind"]:
            case "log":
                self._log.log(_log(record["message"], _LEVELS.get(record["level"]), record, stamp), log_time=at)
            case "run.end":
                level = LogLevel.Info if record["status"] == "passed" else LogLevel.Error
                text = f"{record['status']}: {record['reason']}" if record["reason"] else record["status"]
                self._log.log(_log(text, level, record, stamp), log_time=at)
            case "scene":
                if frames := list(_frames_of_scene(record, stamp)):
                    self._frames.log(FrameTransforms(transforms=frames), log_time=at)
                self._scene.log(scene_update(record, stamp), log_time=at)
                if record.get("map") is not None:
                    self._map.log(grid_of(record["map"], stamp), log_time=at)
            case "entity":
                self._place(record["entity"])
                self._scene.log(entity_update(record["entity"], stamp), log_time=at)
            case "poses":
                self._frames.log(FrameTransforms(transforms=list(self._transforms(record, stamp))), log_time=at)
                if record.get("removed"):
                    self._scene.log(removal_update(record["removed"], stamp), log_time=at)
            case "path":
                self._path(record["entity"]).log(_path(record, stamp), log_time=at)
            case "scan":
                self._scan(record["entity"], record["sensor"]).log(_scan(record, stamp), log_time=at)

    def _place(self, entity: Record) -> None:
        """Keep whether the poses of an entity are those of an odometry."""
        if entity.get("frame", MAP) == MAP:
            self._by_odometry.discard(entity["name"])
        else:
            self._by_odometry.add(entity["name"])

    def _transforms(self, record: Record, stamp: Timestamp) -> Iterator[FrameTransform]:
        for robot, links in record.get("links", {}).items():
            yield from _frames_of_links(robot, links, stamp)
        for name, pose in record["entities"].items():
            parent = f"{name}/odom" if name in self._by_odometry else MAP
            if parent != MAP:  # its place in the map is unknown; the origin stands for it
                yield _transform(MAP, parent, _ORIGIN, stamp)
            yield _transform(parent, name, pose, stamp)
        for name, (x, y, yaw) in record.get("believed", {}).items():
            believed = (x, y, 0.0, 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
            yield _transform(MAP, f"{name}_believed", believed, stamp)

    def _path(self, entity: str) -> PosesInFrameChannel:
        if entity not in self._paths:
            self._paths[entity] = PosesInFrameChannel(f"/{entity}/plan", context=self._context)
        return self._paths[entity]

    def _scan(self, entity: str, sensor: str) -> LaserScanChannel:
        topic = f"/{entity}/{sensor}"
        if topic not in self._scans:
            self._scans[topic] = LaserScanChannel(topic, context=self._context)
        return self._scans[topic]


def _log(message: str, level: LogLevel | None, record: Record, stamp: Timestamp) -> Log:
    file, _, place = str(record.get("source") or "").partition(":")
    line = place.partition(":")[0]
    return Log(
        timestamp=stamp,
        level=LogLevel.Unknown if level is None else level,
        message=message,
        name="seoro",
        file=file,
        line=int(line) if line.isdecimal() else 0,
    )


def _frames_of_scene(scene: Record, stamp: Timestamp) -> Iterator[FrameTransform]:
    """Yield the frames of links in the posture of a scene."""
    for entity in scene["entities"]:
        yield from _frames_of_links(entity["name"], entity.get("links", {}), stamp)


def _frames_of_links(
    robot: str, links: Mapping[str, Sequence[float]], stamp: Timestamp
) -> Iterator[FrameTransform]:
    for link, pose in links.items():
        yield _transform(robot, link_frame(robot, link), pose, stamp)


def _transform(parent: str, child: str, pose: Sequence[float], stamp: Timestamp) -> FrameTransform:
    x, y, z, *rotation = pose[:7]
    return FrameTransform(
        timestamp=stamp,
        parent_frame_id=parent,
        child_frame_id=child,
        translation=Vector3(x=x, y=y, z=z),
        rotation=to_quaternion(rotation),
    )


def _path(record: Record, stamp: Timestamp) -> PosesInFrame:
    poses = [Pose(position=Vector3(x=x, y=y, z=0.0), orientation=UPRIGHT) for x, y in record["points"]]
    return PosesInFrame(timestamp=stamp, frame_id=MAP, poses=poses)


def _scan(record: Record, stamp: Timestamp) -> LaserScan:
    ranges = [math.inf if each is None else float(each) for each in record["ranges"]]
    start = record["angle_min"]
    return LaserScan(
        timestamp=stamp,
        frame_id=record["entity"],
        pose=to_pose(record["pose"]),
        start_angle=start,
        end_angle=start + record["angle_increment"] * max(0, len(ranges) - 1),
        ranges=ranges,
    )
