"""Traces of bags."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from seoro.bridges.ros2.recording.metadata import BagTopic
from seoro.cli.main import main
from seoro.report.folder import Results
from seoro.report.frames import Frame
from seoro.report.reading import Reading
from tests.bridges.ros2.recording.bags import SECOND, TYPES, write
from tests.traces.trace_records import RECORDS, trace

TF, SCAN = "tf2_msgs/msg/TFMessage", "sensor_msgs/msg/LaserScan"
GRID, LOG, PATH = "nav_msgs/msg/OccupancyGrid", "rcl_interfaces/msg/Log", "nav_msgs/msg/Path"


def topic(name: str, type_: str) -> BagTopic:
    return BagTopic(name, type_, TYPES.type_hash(type_))


def frame(parent: str, child: str, x: float, at: int = 0, turn: float = 0.0) -> bytes:
    header = {"stamp": {"sec": at // SECOND, "nanosec": at % SECOND}, "frame_id": parent}
    rotation = {"z": math.sin(turn / 2), "w": math.cos(turn / 2)}
    transform = {"translation": {"x": x}, "rotation": rotation}
    return TYPES.encode(TF, {"transforms": [{"header": header, "child_frame_id": child, "transform": transform}]})


def read(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text().splitlines()]


@pytest.mark.parametrize("namespace", ["", "/bot1"])
async def test_frames_scans_map_and_logs_of_a_robot_become_a_trace(tmp_path: Path, namespace: str) -> None:
    tf, static = topic(f"{namespace}/tf", TF), topic(f"{namespace}/tf_static", TF)
    scans, plans = topic(f"{namespace}/scan", SCAN), topic(f"{namespace}/plan", PATH)
    grids, logs = topic("/map", GRID), topic("/rosout", LOG)
    scan = TYPES.encode(SCAN, {"header": {"frame_id": "laser"}, "angle_increment": 0.5, "ranges": [1.0, math.inf]})
    info = {"resolution": 0.05, "width": 2, "height": 1, "origin": {"orientation": {"w": 1.0}}}
    plan = {"poses": [{"pose": {"position": {"x": 1.0}}}, {"pose": {"position": {"x": 2.0}}}]}
    messages = [
        (static.name, frame("base_link", "laser", 0.25), 0),
        (grids.name, TYPES.encode(GRID, {"info": info, "data": [100, -1]}), 0),
        (tf.name, frame("map", "odom", 1.0), 0),
        *(
            (tf.name, frame("odom", "base_link", at / 10, at * SECOND // 50), at * SECOND // 50)
            for at in range(51)
        ),
        (scans.name, scan, SECOND),
        (plans.name, TYPES.encode(PATH, plan), SECOND),
        (logs.name, TYPES.encode(LOG, {"level": 40, "name": "nav", "msg": "stuck"}), SECOND),
    ]
    folder = await write(tmp_path / "drive", messages, tf, static, scans, plans, grids, logs)
    assert main(["bag", str(folder), "--trace", str(tmp_path / "drive.jsonl")]) == 0
    records = read(tmp_path / "drive.jsonl")
    name = namespace.strip("/") or "robot"
    assert [record["seq"] for record in records] == list(range(len(records)))
    assert (records[0]["kind"], records[0]["scenario"]) == ("run.start", "drive")
    by_kind: dict[str, list[dict[str, Any]]] = {}
    for record in records:
        by_kind.setdefault(record["kind"], []).append(record)
    assert by_kind["entity"][0]["entity"] == {"name": name, "kind": "robot", "real": True, "shapes": []}
    poses = by_kind["poses"]
    assert 10 <= len(poses) <= 12  # ten per second
    assert poses[0]["entities"][name][0] == pytest.approx(1.0)
    assert poses[-1]["entities"][name][0] > 5.0
    [found] = by_kind["scan"]
    assert (found["entity"], found["pose"][0], found["ranges"]) == (name, 0.25, [1.0, None])
    assert by_kind["path"][0]["points"] == [[1.0, 0.0], [2.0, 0.0]]
    assert (by_kind["scene"][0]["map"]["width"], by_kind["log"][0]["message"]) == (2, "nav: stuck")
    reading = Reading()
    with (tmp_path / "drive.jsonl").open("rb") as file:
        reading.read(file)
    frame_of_page = Frame(reading, Results(), lambda _: None)
    assert json.loads(frame_of_page.text)["notes"] == ["The trace was made from a bag. It has no verdict."]


async def test_robots_with_odometry_only_have_poses(tmp_path: Path) -> None:
    odometry = topic("/bot1/odom", "nav_msgs/msg/Odometry")
    messages = [
        (
            odometry.name,
            TYPES.encode(odometry.type, {"pose": {"pose": {"position": {"x": float(at)}}}}),
            at * SECOND,
        )
        for at in range(3)
    ]
    folder = await write(tmp_path / "drive", messages, odometry)
    assert main(["bag", str(folder), "--trace", str(tmp_path / "drive.jsonl")]) == 0
    records = read(tmp_path / "drive.jsonl")
    [entity] = [record["entity"] for record in records if record["kind"] == "entity"]
    assert (entity["name"], entity["frame"]) == ("bot1", "odom")
    assert [each["entities"]["bot1"][0] for each in records if each["kind"] == "poses"] == [0.0, 1.0, 2.0]


def test_a_bag_made_from_a_trace_gives_the_same_trace(tmp_path: Path) -> None:
    file = trace(tmp_path, RECORDS)
    assert main(["trace", file, "--bag", str(tmp_path / "run")]) == 0
    assert main(["bag", str(tmp_path / "run"), "--trace", str(tmp_path / "again.jsonl")]) == 0
    assert read(tmp_path / "again.jsonl") == read(Path(file))


def test_a_missing_bag_leaves_no_trace(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bag", str(tmp_path / "none"), "--trace", str(tmp_path / "none.jsonl")]) == 2
    assert "none" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
