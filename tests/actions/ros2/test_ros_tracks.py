"""Poses of the robots of a ROS 2 system in traces."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import RosNode, connect
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.embed import prepare
from seoro.embed.options import Options, Ros
from tests.runtime.conftest import load_text

pytestmark = pytest.mark.anyio

TF, ODOMETRY, STRING = "tf2_msgs/msg/TFMessage", "nav_msgs/msg/Odometry", "std_msgs/msg/String"
SCENARIO = """import osc.ros
import osc.robotics
scenario main:
    tb: differential_drive_robot
    do wait_for_data("/go", "std_msgs/msg/String")
"""
DEADLINE = 90.0  # [s]


@pytest.fixture
async def node(router: str) -> AsyncIterator[RosNode]:
    """Yield a node of the robot."""
    async with (
        connect(router, types=TypeStore.bundled(), dialect=RmwZenoh()) as system,
        system.node("robot") as made,
    ):
        yield made


def transform(parent: str, child: str, x: float) -> dict[str, Any]:
    moved = {"translation": {"x": x}, "rotation": {"w": 1.0}}
    return {"transforms": [{"header": {"frame_id": parent}, "child_frame_id": child, "transform": moved}]}


class Traced:
    """Records of a run on the system, as they come."""

    def __init__(self, records: AsyncIterator[dict[str, Any]]) -> None:
        self._records = records

    async def next(self, kind: str) -> dict[str, Any]:
        """Wait for the next record of a kind."""
        with anyio.fail_after(DEADLINE):
            async for record in self._records:
                if record["kind"] == kind:
                    return record
        raise AssertionError(f"the run ended without a record `{kind}`")


async def test_robots_are_placed_by_odometry_until_they_are_localised(
    node: RosNode, router: str, tmp_path: Path
) -> None:
    options = Options(seed=0, ros=Ros(router, dialect="rmw_zenoh"), poses=20.0)
    async with (
        node.publishing("/odom", ODOMETRY) as odometry,
        node.publishing("/tf", TF) as frames,
        node.publishing("/go", STRING) as go,
        prepare(load_text(tmp_path, SCENARIO, ()), options) as run,
        run.running(),
    ):
        traced = Traced(run.trace())
        with anyio.fail_after(DEADLINE):
            await frames.wait_for_subscription()
            await odometry.wait_for_subscription()  # as no transform places the robot
        odometry.publish({"child_frame_id": "base_link", "pose": {"pose": {"position": {"x": 0.25}}}})
        entity = (await traced.next("entity"))["entity"]
        assert entity == {"name": "tb", "kind": "robot", "real": True, "shapes": [], "frame": "odom"}
        assert (await traced.next("poses"))["entities"]["tb"][:3] == (0.25, 0.0, 0.0)
        frames.publish(transform("odom", "base_link", 0.5))
        assert (await traced.next("poses"))["entities"]["tb"][:3] == (0.5, 0.0, 0.0)
        frames.publish(transform("map", "odom", 2.0))
        assert (await traced.next("entity"))["entity"].get("frame") is None
        assert (await traced.next("poses"))["entities"]["tb"][0] == 2.5
        go.publish({"data": ""})
        assert (await traced.next("run.end"))["status"] == "passed"


async def test_robots_in_namespaces_have_their_names(node: RosNode, router: str, tmp_path: Path) -> None:
    options = Options(seed=0, ros=Ros(router, dialect="rmw_zenoh"), poses=20.0)
    async with (
        node.publishing("/bot1/tf", TF) as first,
        node.publishing("/fleet/bot2/odom", ODOMETRY) as second,
        node.publishing("/clock", "rosgraph_msgs/msg/Clock"),
        prepare(load_text(tmp_path, SCENARIO, ()), options) as run,
        run.running(),
    ):
        traced = Traced(run.trace())
        with anyio.fail_after(DEADLINE):
            await first.wait_for_subscription()
            await second.wait_for_subscription()
        first.publish(transform("map", "base_footprint", 1.0))
        entity = (await traced.next("entity"))["entity"]
        assert (entity["name"], entity["real"]) == ("bot1", False)  # simulated, as there is a clock
        second.publish({"header": {"frame_id": "bot2/odom"}, "pose": {"pose": {"position": {"x": 3.0}}}})
        entity = (await traced.next("entity"))["entity"]
        assert (entity["name"], entity["frame"]) == ("fleet/bot2", "odom")
        assert (await traced.next("poses"))["entities"] == {"fleet/bot2": (3.0, 0, 0, 0, 0, 0, 1, *[0] * 6)}


async def test_rate_zero_follows_nothing(node: RosNode, router: str, tmp_path: Path) -> None:
    options = Options(seed=0, ros=Ros(router, dialect="rmw_zenoh"), poses=0.0)
    async with (
        node.publishing("/tf", TF),
        node.publishing("/go", STRING) as go,
        prepare(load_text(tmp_path, SCENARIO, ()), options) as run,
        run.running(),
    ):
        with anyio.fail_after(DEADLINE):
            await go.wait_for_subscription()
        assert not node.others(node.graph.subscriptions("/tf"))
        go.publish({"data": ""})
        assert [record["kind"] async for record in run.trace() if record["kind"] in ("poses", "entity")] == []
