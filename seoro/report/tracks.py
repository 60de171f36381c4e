"""Poses of robots and movable bodies over time, planned paths and laser scans."""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from typing import Any, Final

from seoro.report.columns import Packed, integers, reals, scaled, scaled_all
from seoro.traces.reader import Record

FIELDS: Final = ("x", "y", "z", "qx", "qy", "qz", "qw", "vx", "vy", "vz", "wx", "wy", "wz")
MOST_ENTITIES: Final = 2_000
_ZEROS: Final = [0] * len(FIELDS)
_POSE: Final = 7  # fields without velocities
_POINTS: Final = 500_000  # of all paths, and of all scans


class Track:
    """Poses of one robot or body."""

    def __init__(self) -> None:
        self.times = reals()
        self.columns: tuple[array[int], ...] = tuple(integers() for _ in FIELDS)
        self._adders = [column.append for column in self.columns]

    def add(self, time: float, values: list[Any]) -> None:
        """Append a sample; missing velocities are 0."""
        if self.times and time < self.times[-1]:
            return  # a run that went back to a snapshot
        self.times.append(time)
        found = scaled_all(values[: len(FIELDS)])
        found += _ZEROS[len(found) :]
        for add, value in zip(self._adders, found, strict=True):
            add(value)


class _Lists:
    """Lists of numbers with a time and an entity, such as planned paths."""

    def __init__(self) -> None:
        self.times = reals()
        self.entities = integers()
        self.ends = integers()
        self.values = integers()

    def add(self, time: float, entity: int, values: list[int]) -> bool:
        """Append a list; False if there are too many points."""
        if len(self.values) + len(values) > _POINTS:
            return False
        self.times.append(time)
        self.entities.append(entity)
        self.values.extend(values)
        self.ends.append(len(self.values))
        return True

    def pack(self, packed: Packed, name: str) -> None:
        packed.add_table(name, [("t", self.times), ("entity", self.entities), ("end", self.ends)])
        start = packed.start(f"{name}.value")
        packed.position[f"{name}.value"] = len(self.values)
        packed.add(f"{name}.value", self.values[start:])


class Tracks:
    """All tracks of a run.

    Attributes:
        omitted: Number of samples, paths and scans beyond the limits.
    """

    def __init__(self) -> None:
        self.omitted = 0
        self._names: dict[str, int] = {}
        self._tracks: list[Track] = []
        self._believed: dict[int, Track] = {}
        self._links: dict[tuple[str, str], Track] = {}  # by robot and link
        self._paths = _Lists()
        self._scans = _Lists()
        self._beams: list[list[float]] = []

    @property
    def is_empty(self) -> bool:
        """Whether the trace has no poses."""
        return not self._tracks

    def poses(self, record: Record, seq: int = 0) -> None:
        """Add a record `poses`; malformed parts are skipped."""
        time = _time(record)
        for name, values in _items(record, "entities"):
            if isinstance(values, list) and len(values) >= _POSE and (number := self._number(name)) is not None:
                self._tracks[number].add(time, values)
        for robot, links in _items(record, "links"):
            self._add_links(robot, links, time)
        for name, values in _items(record, "believed"):
            if isinstance(values, list) and len(values) == 3 and (number := self._number(name)) is not None:
                self._believed.setdefault(number, Track()).add(time, [values[0], values[1], 0, 0, 0, values[2], 0])

    def _add_links(self, robot: str, links: object, time: float) -> None:
        for link, values in links.items() if isinstance(links, dict) else ():
            if not isinstance(values, list) or len(values) < _POSE:
                continue
            if (robot, link) not in self._links and len(self._links) >= MOST_ENTITIES:
                self.omitted += 1
                continue
            self._links.setdefault((robot, link), Track()).add(time, values)

    def path(self, record: Record, seq: int = 0) -> None:
        """Add a record `path`; malformed parts are skipped."""
        number = self._number(str(record.get("entity")))
        points = record.get("points")
        if number is None or not isinstance(points, list):
            return
        flat = scaled_all([value for point in points if isinstance(point, list) for value in point[:2]])
        self.omitted += not self._paths.add(_time(record), number, flat)

    def scan(self, record: Record, seq: int = 0) -> None:
        """Add a record `scan`; malformed parts are skipped."""
        number = self._number(str(record.get("entity")))
        ranges, pose = record.get("ranges"), record.get("pose")
        if number is None or not isinstance(ranges, list) or not isinstance(pose, list) or len(pose) < _POSE:
            return
        first, step = record.get("angle_min"), record.get("angle_increment")
        if not isinstance(first, int | float) or not isinstance(step, int | float):
            return
        values = [-1 if value is None else scaled(value) for value in ranges]
        if self._scans.add(_time(record), number, values):
            self._beams.append([*(float(value) for value in pose[:_POSE]), float(first), float(step)])
        else:
            self.omitted += 1

    def pack(self, packed: Packed) -> list[dict[str, Any]]:
        """Append the columns, and return the descriptions of new entities."""
        for number, track in enumerate(self._tracks):
            _pack(packed, f"track.{number}", track)
        for number, track in self._believed.items():
            _pack(packed, f"believed.{number}", track)
        for number, track in enumerate(self._links.values()):
            _pack(packed, f"link.{number}", track)
        self._paths.pack(packed, "paths")
        self._scans.pack(packed, "scans")
        return [{"name": name} for name in packed.rest("entities", list(self._names))]

    @property
    def links(self) -> list[list[str]]:
        """Robot and name of each link with poses, in the order of their columns."""
        return [list(names) for names in self._links]

    @property
    def beams(self) -> list[list[float]]:
        """Pose of the sensor, first angle and step of each scan."""
        return self._beams

    def _number(self, name: str) -> int | None:
        found = self._names.get(name)
        if found is None:
            if len(self._names) >= MOST_ENTITIES:
                self.omitted += 1
                return None
            found = self._names[name] = len(self._names)
            self._tracks.append(Track())
        return found


def _pack(packed: Packed, prefix: str, track: Track) -> None:
    packed.add_table(prefix, [("t", track.times), *zip(FIELDS, track.columns, strict=True)])


def _time(record: Record) -> float:
    time = record.get("time")
    return float(time) if isinstance(time, int | float) else float(record["t"])


def _items(record: Record, name: str) -> Iterator[tuple[str, Any]]:
    found = record.get(name)
    if isinstance(found, dict):
        yield from found.items()
