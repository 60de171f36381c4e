"""Traces for the tests of reports, in the present format."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

TEXT = """\
import osc.types
import osc.helpers

scenario main:
    event go
    do serial:
        log("begin")
        wait elapsed(2s)
        wait @go
        log("never")
    with:
        timeout(5s)
"""
WALL = "2026-01-01T00:00:00.123456+00:00"
HOSTILE = "<img src=x onerror=document.title='owned'></script><script>document.title='owned'</script>"
REVERSED = "safe\u202egpj.exe\u2066"


def records(name: str = "main", *, log: str = "begin", robot: str = "tb4") -> list[dict[str, Any]]:
    """The records of a run that fails after 5 s, with sources, tree, causes, a scene and poses.

    Args:
        name: Name of the scenario.
        log: Its first message.
        robot: Name of its robot.
    """
    made: list[dict[str, Any]] = []

    def add(t: float, kind: str, cause: int | None = None, **fields: Any) -> int:
        because = {} if cause is None else {"cause": cause}
        made.append(
            {"seq": len(made), "t": t, "wall": "2026-01-01T00:00:00+00:00", "kind": kind, **fields, **because}
        )
        return len(made) - 1

    def start(t: float, number: int, parent: int | None, type_: str, title: str, place: str, cause: int) -> int:
        line, column, end = place.split(":")
        path = name if parent is None else f"{name}/{title}[{number}]"
        fields = {"id": number, "parent": parent, "type": type_, "name": title, "path": path, "node": number}
        source, last = f"main.osc:{line}:{column}", f"{line}:{end}"
        return add(t, "behavior.start", cause, **fields, source=source, source_end=last)

    def end(t: float, number: int, status: str, cause: int, reason: str = "") -> int:
        return add(t, "behavior.end", cause, id=number, status=status, reason=reason)

    tree = [
        {"id": 0, "parent": None, "scenario": "main", "type": "scenario", "name": name, "source": "main.osc:4:10"},
        {"id": 1, "parent": 0, "scenario": "main", "type": "serial", "name": "serial", "source": "main.osc:6:8"},
        {"id": 2, "parent": 1, "scenario": "main", "type": "action", "name": "log", "source": "main.osc:7:9"},
        {"id": 3, "parent": 1, "scenario": "main", "type": "wait", "name": "wait", "source": "main.osc:8:9"},
        {"id": 4, "parent": 1, "scenario": "main", "type": "wait", "name": "wait", "source": "main.osc:9:9"},
        {"id": 5, "parent": 1, "scenario": "main", "type": "action", "name": "log", "source": "main.osc:10:9"},
    ]
    begun = add(
        0.0,
        "run.start",
        scenario=name,
        file="main.osc",
        seed=7,
        parameters={"robot": robot},
        overrides={},
        clock="sim",
        version="0.1.0",
        format="1.1",
        sources=[{"name": "main.osc", "sha256": "0", "text": TEXT}, {"name": "osc/helpers.osc", "library": True}],
        tree=tree,
    )
    add(0.0, "scene", **scene(robot))
    main = start(0.0, 0, None, "scenario", name, "4:10:14", begun)
    serial = start(0.0, 1, 0, "serial", "serial", "6:8:14", main)
    logs = start(0.0, 2, 1, "action", "log", "7:9:21", serial)
    add(0.0, "log", logs, level="info", message=log, source="main.osc:7:9")
    logged = end(0.0, 2, "succeeded", logs)
    waits = start(0.0, 3, 1, "wait", "wait", "8:9:25", logged)
    for tick in range(51):
        if tick == 20:
            waited = end(2.0, 3, "succeeded", waits)
            add(2.0, "variable", waited, path="count", value=2, of=0, field="count")
            start(2.0, 4, 1, "wait", "wait", "9:9:17", waited)
        moved = {robot: [tick / 10, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]}
        add(tick / 10, "poses", time=tick / 10, entities=moved)
    ended = end(5.0, 4, "cancelled", begun)
    end(5.0, 1, "failed", ended, "timeout: still running after 5 s")
    failed = end(5.0, 0, "failed", len(made) - 1, "timeout: still running after 5 s")
    waiting = {
        "kind": "waits",
        "text": "wait @go",
        "source": "main.osc:9:9",
        "path": "main",
        "since": 2.0,
        "due": None,
        "values": [],
        "event": "go",
        "emitters": [],
    }
    explanation = {"t": 5.0, "path": "main", "values": [], "activities": [waiting], "more": 0}
    reason = "timeout: still running after 5 s"
    found = {"status": "failed", "reason": reason, "source": "main.osc:12:9", "explanation": explanation}
    add(5.0, "run.end", failed, **found, duration=5.0, cancelled=[])
    return made


def scene(robot: str) -> dict[str, Any]:
    """A world with a wall, a map and a robot."""
    cells = bytes(100 if column in (0, 19) else 0 for _ in range(10) for column in range(20))
    return {
        "time": 0.0,
        "world": "hall",
        "simulator": "mujoco",
        "extent": [-1.0, -2.0, 7.0, 2.0],
        "frame": "map",
        "shapes": [
            {
                "entity": "",
                "kind": "box",
                "pose": [6.0, 0, 0.5, 0, 0, 0, 1],
                "size": [0.2, 3, 1],
                "color": "#888888",
            }
        ],
        "entities": [
            {
                "name": robot,
                "kind": "robot",
                "model": "turtlebot4",
                "real": False,
                "footprint": [[0.2, 0.2], [-0.2, 0.2], [-0.2, -0.2], [0.2, -0.2]],
                "height": 0.35,
            }
        ],
        "map": {
            "resolution": 0.4,
            "origin": [-1.0, -2.0, 0.0],
            "width": 20,
            "height": 10,
            "data": base64.b64encode(zlib.compress(cells)).decode(),
        },
        "places": [{"name": "kitchen", "pose": [3.0, 1.0, 0.0]}],
    }


def write(folder: Path, found: Iterable[dict[str, Any]]) -> Path:
    """Write records as the trace of an output folder."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "trace.jsonl"
    with path.open("w", encoding="utf-8") as file:
        file.writelines(json.dumps(record) + "\n" for record in found)
    return path


def many_records(count: int) -> Iterator[dict[str, Any]]:
    """Yield the records of a run that repeats ten behaviors and counts, with causes and poses of two robots."""
    start = {
        "scenario": "main",
        "file": "main.osc",
        "seed": 1,
        "parameters": {},
        "overrides": {},
        "clock": "virtual",
    }
    sources = [{"name": "main.osc", "sha256": "0", "text": "scenario main:\n" + "    wait elapsed(1s)\n" * 20}]
    yield {"seq": 0, "t": 0.0, "kind": "run.start", **start, "sources": sources, "tree": [], "format": "1.1"}
    seq, number, time_, round_ = 0, 0, 0.0, 0
    while seq < count - 2:
        round_ += 1
        for member in range(10):
            time_ = round(time_ + 0.01, 6)
            seq += 1
            name = f"robot.drive_{member}"
            path = f"main/serial[0]#{round_}/{name}[{member}]"
            place = {"source": f"main.osc:{member + 2}:5", "source_end": f"{member + 2}:21", "parent": None}
            common = {"id": number, "type": "action", "name": name, "path": path, **place, "cause": seq - 1}
            yield {"seq": seq, "t": time_, "wall": WALL, "kind": "behavior.start", **common}
            seq += 1
            value = {"path": f"count_{member}", "value": round_, "of": 0, "field": "count", "cause": seq - 1}
            yield {"seq": seq, "t": time_, "wall": WALL, "kind": "variable", **value}
            seq += 1
            status = "failed" if number % 50_000 == 49_999 else "succeeded"
            end = {"id": number, "status": status, "reason": "", "cause": seq - 1}
            yield {"seq": seq, "t": round(time_ + 0.008, 6), "wall": WALL, "kind": "behavior.end", **end}
            number += 1
        seq += 1
        moved = {f"tb{robot}": [time_ % 7, robot + 0.5, 0, 0, 0, 0, 1, 0.3, 0, 0, 0, 0, 0] for robot in (1, 2)}
        yield {"seq": seq, "t": time_, "wall": WALL, "kind": "poses", "time": time_, "entities": moved}
    end = {"status": "passed", "reason": "", "source": "", "explanation": None, "duration": time_}
    yield {"seq": seq + 1, "t": time_, "wall": WALL, "kind": "run.end", **end, "cause": seq}
