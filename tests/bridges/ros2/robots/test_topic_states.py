"""Connection from a bridge to its robots, as `seoro doctor` reports it."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from pathlib import Path

import anyio

from seoro.bridges.wire.lab import TopicState
from seoro.doctor.findings import Health
from seoro.doctor.lab import Places, check_lab
from seoro.lab.probes import probe
from tests.bridges.ros2.robots.conftest import BRIDGE, FAKE_ROBOT, Bridged
from tests.routers import free_endpoint, process, router_process

DEADLINE = 30.0  # [s]


async def received(
    endpoint: str, name: str, is_so: Callable[[dict[str, TopicState]], bool]
) -> dict[str, TopicState]:
    """Wait until the topics of a robot satisfy a condition, and return them."""
    with anyio.fail_after(DEADLINE):
        while True:
            seen = await probe(endpoint, exchanges=1)
            robots = [robot for node in seen.nodes if node.state for robot in node.state.robots]
            topics = {topic.topic: topic for robot in robots if robot.name == name for topic in robot.topics}
            if topics and is_so(topics):
                return topics
            await anyio.sleep(0.05)


async def test_topics_with_and_without_messages_are_reported(bridged: Bridged) -> None:
    topics = await received(bridged.endpoint, "tb", lambda topics: not topics["/tb/odom"].why)
    assert topics["/tb/odom"].seen is not None
    silent = [each for each in topics.values() if each.seen is None]
    assert silent
    assert all(each.why for each in silent)


async def test_a_robot_without_answers_is_reported_with_its_bridge(tmp_path: Path) -> None:
    router, endpoint = free_endpoint(), f"unixsock-stream/{tmp_path}/bridge"
    with (
        router_process(router),
        process(str(FAKE_ROBOT), str(tmp_path), router, "tb", "geometry_msgs/msg/Twist") as robot,
        process("-c", BRIDGE, router, endpoint, "tb", "ghost"),
    ):
        await received(endpoint, "tb", lambda topics: not topics["/tb/odom"].why)
        found = [each async for each in check_lab(Places((endpoint,)), None)]
        assert all(each.health is not Health.FAILED for each in found if each.what == "ros2/tb")
        ghost = {each.text: each for each in found if each.what == "ros2/ghost"}
        assert ghost["no messages received"].health is Health.FAILED
        assert "`--ros`" in ghost["no messages received"].help
        missing = ghost["no publisher of /ghost/odom: the odometry of the base is not running"]
        assert missing.health is Health.FAILED
        assert missing.help.endswith("found: /tb/odom")
        os.kill(robot.pid, signal.SIGKILL)
        await received(endpoint, "tb", lambda topics: topics["/tb/odom"].why == "no publisher")
