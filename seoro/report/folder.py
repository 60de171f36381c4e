"""Files beside a trace that a report also shows."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from seoro.files.inputs import Kind, open_input
from seoro.report.reading import Reading

_MEASUREMENTS: Final = "measurements.json"
_COVERAGE: Final = "coverage.json"
_TRAJECTORIES: Final = "trajectories.csv"
RESULTS: Final = (_MEASUREMENTS, _COVERAGE, _TRAJECTORIES)
_SCENE: Final = {"simulator": "engine", "world": "world"}
_MOST_ROWS: Final = 500_000  # of trajectories; the table of a run has at most 100,000


@dataclass(frozen=True)
class Results:
    """Results beside a trace.

    Args:
        measurements: Content of `measurements.json`; empty if missing.
        coverage: Content of `coverage.json`; empty if missing.
    """

    measurements: Mapping[str, Any] = field(default_factory=dict)
    coverage: Mapping[str, Any] = field(default_factory=dict)


def results_of(folder: Path | None, reading: Reading) -> Results:
    """Read the results of a run that has ended, and add its trajectories to the data of its trace.

    Args:
        folder: Folder of the results; None for none.
        reading: Data of the trace; without a scene, it gets the simulator and the world from the measurements.
    """
    if folder is None:
        return Results()
    found = Results(measurements_of(folder), read_json(folder / _COVERAGE))
    add_trajectories(folder / _TRAJECTORIES, reading)
    if reading.scene is None and found.measurements:
        reading.scene = {key: found.measurements.get(name) for key, name in _SCENE.items()}
    return found


def measurements_of(folder: Path) -> dict[str, Any]:
    """Read the measurements of a run; empty if they are missing or invalid."""
    return read_json(folder / _MEASUREMENTS)


def read_json(path: Path) -> dict[str, Any]:
    """Read an object from a JSON file; empty if the file is missing or invalid."""
    try:
        with open_input(path, Kind.OUTPUT) as file:
            found = json.load(file)
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def add_trajectories(path: Path, reading: Reading) -> None:
    """Add the table of trajectories: errors of localisation, commands, and poses if the trace has none."""
    needs_poses = reading.tracks.is_empty
    try:
        with open_input(path, Kind.OUTPUT) as file:
            text = file.read().decode("utf-8", "replace")
    except OSError:
        return
    for number, row in enumerate(csv.DictReader(text.splitlines())):
        if number >= _MOST_ROWS:
            return
        entity, time, x, y = row.get("entity") or "", *(_number(row.get(key)) for key in ("time", "x", "y"))
        if time is None or x is None or y is None:
            continue
        if needs_poses:
            yaw = _number(row.get("yaw")) or 0.0
            z = _number(row.get("z")) or 0.0
            pose = {entity: [x, y, z, 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)]}
            reading.tracks.poses({"time": time, "t": time, "entities": pose})
        believed_x, believed_y = _number(row.get("believed_x")), _number(row.get("believed_y"))
        if believed_x is not None and believed_y is not None:
            error = math.hypot(x - believed_x, y - believed_y)
            reading.series.add("entity", f"{entity}: error of the localisation", time, error, "m")
        linear = _number(row.get("command_linear"))
        if linear is not None:
            reading.series.add("entity", f"{entity}: commanded speed", time, linear, "m/s")


def _number(text: str | None) -> float | None:
    try:
        found = float(text or "")
    except ValueError:
        return None
    return found if math.isfinite(found) else None
