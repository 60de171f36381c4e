"""Poses of a genuine node in the trace, the recording and the report of a run with `--ros`."""

from __future__ import annotations

import json
import math
import subprocess
from contextlib import suppress
from pathlib import Path
from typing import Any

import anyio
import pytest

from tests.bridges.ros2.genuine.conftest import DEADLINE, Ros2
from tests.bridges.ros2.genuine.steering import SteeredNode, steered
from tests.bridges.ros2.genuine.test_commands import SEORO

pytestmark = [pytest.mark.anyio, pytest.mark.ros2]

ODOMETRY, TF, STRING = "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage", "std_msgs/msg/String"
SCENARIO = """import osc.ros
import osc.robotics
scenario main:
    rover: differential_drive_robot
    do wait_for_data("/go", "std_msgs/msg/String")
"""


def odometry(x: float) -> dict[str, Any]:
    pose = {"position": {"x": x, "y": 0.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 1.0, "w": 0.0}}
    return {"header": {"frame_id": "odom"}, "child_frame_id": "base_footprint", "pose": {"pose": pose}}


def frame(parent: str, child: str, x: float) -> dict[str, Any]:
    transform = {"translation": {"x": x, "y": 0.0, "z": 0.0}, "rotation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
    return {"transforms": [{"header": {"frame_id": parent}, "child_frame_id": child, "transform": transform}]}


async def published_until(
    genuine: SteeredNode, topic: str, message: dict[str, Any], trace: Path, text: str
) -> None:
    """Publish a message repeatedly, as robots do, until a trace contains a text.

    The router knows a subscription earlier than the publisher does, whose first messages may be lost.
    """
    with anyio.fail_after(DEADLINE):
        while not trace.exists() or text not in trace.read_text():
            await genuine.ask("publish", topic=topic, messages=[message])
            await anyio.sleep(0.1)


async def test_a_run_records_a_robot_by_odometry_and_then_in_the_map(
    ros2: Ros2, router: str, tmp_path: Path
) -> None:
    (tmp_path / "main.osc").write_text(SCENARIO)
    out = tmp_path / "out"
    trace = out / "trace.jsonl"
    command = [*SEORO, "exec", str(tmp_path / "main.osc"), "--ros", router, "-o", str(out), "--report"]
    async with steered(ros2, router) as genuine:
        await genuine.ask("publisher", topic="/odom", type=ODOMETRY, reliability="best_effort")
        run = await anyio.open_process(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            with anyio.fail_after(DEADLINE):
                while (await genuine.ask("matched", topic="/odom"))["subscriptions"] < 1:
                    await anyio.sleep(0.05)
            for step in range(3):
                await published_until(genuine, "/odom", odometry(step / 4), trace, f'{{"rover": [{step / 4},')
            await genuine.ask("publisher", topic="/tf", type=TF, depth=100)
            with anyio.fail_after(DEADLINE):
                while (await genuine.ask("matched", topic="/tf"))["subscriptions"] < 1:
                    await anyio.sleep(0.05)
            await published_until(genuine, "/tf", frame("map", "odom", 7.0), trace, '{"rover": [7.5,')
            await genuine.ask("publisher", topic="/go", type=STRING, durability="transient_local", depth=1)
            await genuine.ask("publish", topic="/go", messages=[{"data": "go"}])
            with anyio.fail_after(DEADLINE):
                assert await run.wait() == 0
        finally:
            with suppress(ProcessLookupError):
                run.kill()
            await run.aclose()
    records = [json.loads(line) for line in trace.read_text().splitlines()]
    entities = [record["entity"] for record in records if record["kind"] == "entity"]
    robot = {"name": "rover", "kind": "robot", "real": True, "shapes": []}
    assert entities == [{**robot, "frame": "odom"}, robot]
    pose = next(record["entities"]["rover"] for record in records if record["kind"] == "poses")
    assert pose[:7] == pytest.approx([0.0, 0.0, 0.0, 0.0, 0.0, math.sin(math.pi / 2), 0.0], abs=1e-4)
    assert (out / "recording.mcap").exists()
    assert (out / "report.html").exists()
