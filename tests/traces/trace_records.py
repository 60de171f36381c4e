"""Records of a run with a robot, for recordings and bags."""

from __future__ import annotations

import json
import zlib
from base64 import b64encode
from pathlib import Path
from typing import Any

POSE = [1.0, 2.0, 0.0, 0.0, 0.0, 0.7071, 0.7071]
MOVING = [*POSE, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0]
SHAPES: list[dict[str, Any]] = [
    {"kind": "box", "pose": POSE, "size": [1.0, 0.2, 0.5], "color": "#ff8000", "entity": "walls"},
    {"kind": "polygon", "pose": POSE, "size": [2.0], "points": [[0, 0], [1, 0], [0, 1]], "entity": "post"},
]
BODY = [{"kind": "capsule", "pose": [0, 0, 1, 0, 0, 0, 1], "size": [0.2, 1.0], "color": "#000000"}]
CELLS = bytes([0, 100, 255, 0, 0, 0])
MAP = {
    "resolution": 0.05,
    "origin": [-1.0, 0.0, 0.0],
    "width": 3,
    "height": 2,
    "data": b64encode(zlib.compress(CELLS)).decode(),
}
RECORDS: list[dict[str, Any]] = [
    {"kind": "run.start", "t": 0.0, "scenario": "main", "file": "main.osc"},
    {
        "kind": "scene",
        "t": 0.0,
        "time": 0.0,
        "shapes": SHAPES,
        "entities": [{"name": "tb", "shapes": BODY}],
        "map": MAP,
    },
    {"kind": "poses", "t": 1.0, "time": 0.5, "entities": {"tb": MOVING}, "believed": {"tb": [1, 2, 0]}},
    {"kind": "entity", "t": 1.0, "time": 0.6, "entity": {"name": "ball", "shapes": []}},
    {"kind": "poses", "t": 1.0, "time": 0.7, "entities": {}, "removed": ["ball"]},
    {"kind": "path", "t": 1.0, "time": 0.7, "entity": "tb", "points": [[0, 0], [1, 1]]},
    {
        "kind": "scan", "t": 1.0, "time": 0.7, "entity": "tb", "sensor": "lidar", "pose": POSE, "angle_min": -1.0,
        "angle_increment": 0.5, "range_max": 5.0, "ranges": [1.0, None, 2.0],
    },
    {"kind": "log", "t": 1.0, "level": "warning", "message": "half way", "source": "main.osc:7:5"},
    {"kind": "run.end", "t": 2.0, "status": "failed", "reason": "too late", "source": "", "duration": 2.0},
]  # fmt: skip

LOST: list[dict[str, Any]] = [  # a robot that is localised after a while
    {"kind": "entity", "t": 0.0, "time": 0.0, "entity": {"name": "tb", "shapes": [], "frame": "odom"}},
    {"kind": "poses", "t": 0.0, "time": 0.0, "entities": {"tb": MOVING}},
    {"kind": "entity", "t": 1.0, "time": 1.0, "entity": {"name": "tb", "shapes": []}},
    {"kind": "poses", "t": 1.0, "time": 1.0, "entities": {"tb": MOVING}},
]


def trace(folder: Path, records: list[dict[str, Any]]) -> str:
    stamped = [{"seq": at, "wall": f"2026-05-31T10:00:0{at}+00:00", **each} for at, each in enumerate(records)]
    (folder / "trace.jsonl").write_text("".join(json.dumps(each) + "\n" for each in stamped))
    return str(folder / "trace.jsonl")
