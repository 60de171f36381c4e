"""Data of a run for comparisons."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from seoro.report.folder import measurements_of
from seoro.traces.reader import Record

Point = tuple[float, float, float]  # time [s], x and y [m]

_NUMBER: Final = (int, float)
_LEAST_WAY: Final = 0.02  # [m] between points of a path
_MOST_POINTS: Final = 20_000  # of a path
_FAR: Final = 1e6  # [m]
MOST_ENTITIES: Final = 50
_STATUSES: Final = frozenset({"passed", "failed", "error", "cancelled"})


@dataclass(frozen=True)
class ComparedRun:
    """A run.

    Args:
        name: Name for people, such as its folder.
        start: Record `run.start`.
        end: Record `run.end`; None for a killed or active run.
        time: Time of the last record [s].
        scene: Record `scene`; empty without a simulator.
        paths: Points of robots and movable bodies by name, with gaps where they rest.
        measurements: Content of `measurements.json`; empty if missing.
    """

    name: str
    start: Record
    end: Record | None
    time: float
    scene: Mapping[str, Any] = field(default_factory=dict)
    paths: Mapping[str, list[Point]] = field(default_factory=dict)
    measurements: Mapping[str, Any] = field(default_factory=dict)

    @property
    def status(self) -> str:
        """Status in one word."""
        status = None if self.end is None else self.end["status"]
        return "not ended" if status is None else status if status in _STATUSES else "unknown"


def compared_run(name: str, records: Iterable[Record], folder: Path | None) -> ComparedRun:
    """Collect the data of a run.

    Args:
        name: Name for people.
        records: Its records, from the start.
        folder: Folder with its measurements; None for none.
    """
    start: Record = {}
    end: Record | None = None
    scene: Record = {}
    time = 0.0
    paths: dict[str, list[Point]] = {}
    for record in records:
        time = max(time, record["t"])
        match record["kind"]:
            case "run.start":
                start = start or record
            case "run.end":
                end = record
            case "scene":
                scene = scene or record
            case "poses":
                _add(paths, record)
    measurements = {} if folder is None else measurements_of(folder)
    return ComparedRun(name, start, end, time, scene, paths, measurements)


def _add(paths: dict[str, list[Point]], record: Record) -> None:
    for name, pose in record["entities"].items():
        place = _place(pose)
        if place is None or (name not in paths and len(paths) >= MOST_ENTITIES):
            continue
        path = paths.setdefault(name, [])
        x, y = place
        is_new = not path or abs(x - path[-1][1]) + abs(y - path[-1][2]) >= _LEAST_WAY
        if is_new and len(path) < _MOST_POINTS:
            path.append((float(record["time"]), x, y))


def _place(pose: object) -> tuple[float, float] | None:
    """Return x and y of a pose [m]; None if it is malformed or far away."""
    if not (isinstance(pose, list) and len(pose) >= 2):
        return None
    x, y = pose[:2]
    is_near = isinstance(x, _NUMBER) and isinstance(y, _NUMBER) and abs(x) < _FAR and abs(y) < _FAR
    return (float(x), float(y)) if is_near else None


def position(path: list[Point], time: float) -> tuple[float, float]:
    """Return the last point of a path until a time, else its first one."""
    found = path[0]
    for point in path:
        if point[0] > time:
            break
        found = point
    return found[1:]
