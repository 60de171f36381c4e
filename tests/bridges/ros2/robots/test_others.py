"""Two bridges for one robot."""

from __future__ import annotations

import pytest

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.own_nodes import BRIDGE
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.robots.profile import read_profile
from seoro.bridges.ros2.robots.running import BridgedRobot, warn_of_others
from seoro.bridges.ros2.wire import RmwZenoh

pytestmark = pytest.mark.anyio


async def test_that_another_bridge_serves_a_robot_is_told(
    router: str, types: TypeStore, caplog: pytest.LogCaptureFixture
) -> None:
    profile = read_profile("turtlebot4")
    async with (
        connect(router, types=types, dialect=RmwZenoh()) as other,
        other.node(BRIDGE, "/tb1") as bridge,
        bridge.subscribing("tf", "tf2_msgs/msg/TFMessage"),
        connect(router, types=types, dialect=RmwZenoh()) as system,
    ):
        await system.graph.wait_for(lambda graph: graph.subscriptions("/tb1/tf"), 10.0)
        warn_of_others([BridgedRobot("one", profile, "/tb1"), BridgedRobot("two", profile, "/tb2")], system)
    [told] = [record.getMessage() for record in caplog.records]
    assert told.startswith(
        "another bridge serves a robot in the namespace /tb1, too: runs over either would command 'one'"
    )
