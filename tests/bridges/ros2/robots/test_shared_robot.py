"""Two bridges for one robot."""

from __future__ import annotations

import pytest

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import BRIDGE, GUARD, connect
from seoro.bridges.ros2.robots.profile import BridgedRobot, read_profile
from seoro.bridges.ros2.robots.running import warn_if_shared
from seoro.bridges.ros2.wire import RmwZenoh

pytestmark = pytest.mark.anyio


async def test_another_bridge_to_the_same_robot_is_reported(
    router: str, types: TypeStore, caplog: pytest.LogCaptureFixture
) -> None:
    profile = read_profile("turtlebot4").model_copy(update={"tf": "/tf"})  # as robots that share one tree have it
    statuses = "navigate_to_pose/_action/status"
    async with (
        connect(router, types=types, dialect=RmwZenoh()) as other,
        other.node(BRIDGE, "/tb1") as bridge,
        other.node(GUARD, "/tb1") as guard,
        bridge.subscribing("/tf", "tf2_msgs/msg/TFMessage"),
        guard.subscribing(statuses, "action_msgs/msg/GoalStatusArray"),
        connect(router, types=types, dialect=RmwZenoh()) as system,
    ):
        topics = ("/tf", f"/tb1/{statuses}")
        await system.graph.wait_for(lambda graph: all(graph.subscriptions(each) for each in topics), 30.0)
        warn_if_shared([BridgedRobot(each, profile, f"/{each}") for each in ("tb1", "tb2")], system)
    [reported] = [record.getMessage() for record in caplog.records]
    assert reported.startswith(
        "another bridge serves a robot in the namespace /tb1, too: runs over both would command 'tb1'"
    )
