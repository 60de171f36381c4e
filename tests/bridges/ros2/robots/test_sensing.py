"""Waits for force-torque sensors and detectors of a ROS 2 robot behind the bridge."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import anyio
import pytest

from seoro.bridges.robot.connecting import connect_robots
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.robots.profile import Detector
from seoro.bridges.ros2.robots.sensing import DETECTIONS, WRENCH
from seoro.bridges.ros2.topics import Publication
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.errors import BackendRefused, UsageError
from seoro.runtime.contracts.backends import GoalStatus
from seoro.runtime.verdict import RunStatus
from tests.bridges.robot.test_connecting import Ends
from tests.bridges.ros2.robots.conftest import BRIDGE, FAKE_ROBOT, run_on_robot
from tests.routers import free_endpoint, process, router_process

pytestmark = pytest.mark.anyio

PROFILE = """model: rover
kinds: [differential_drive_robot, robot, osc_actor]
base:
  limits: {linear: 0.5, angular: 1.0}
sensors:
  force: {wrist: wrist/wrench, silent: silent/wrench}
  sight:
    eye: {topic: eye/detections, width: 200, height: 100}
    other: {topic: eye/detections}
"""
SCENARIO = (
    "import osc.helpers\nimport osc.nav2\nimport osc.sensors\nscenario main:\n    timeout(30s)\n"
    "    tb: differential_drive_robot\n    do serial:\n"
)


@dataclass(frozen=True)
class Sensed:
    """Endpoints of a bridge and of the router of its robots, `rover` and `plain`."""

    endpoint: str
    router: str


@pytest.fixture(scope="module")
def sensed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Sensed]:
    """Yield a bridge to a robot with sensors, and to another without."""
    folder = tmp_path_factory.mktemp("sensed")
    profile = folder / "rover.yaml"
    profile.write_text(PROFILE)
    bridge = BRIDGE.replace(
        "BridgedRobot(name, profile,",
        f"BridgedRobot(name, read_profile({str(profile)!r}) if name == 'rover' else profile,",
    )
    router, endpoint = free_endpoint(), f"unixsock-stream/{folder}/bridge"
    with (
        router_process(router),
        process(str(FAKE_ROBOT), str(folder), router, "rover", "geometry_msgs/msg/Twist"),
        process("-c", bridge, router, endpoint, "rover", "plain"),
    ):
        yield Sensed(endpoint, router)


@asynccontextmanager
async def publishing(sensed: Sensed, topic: str, kind: str) -> AsyncIterator[Publication]:
    """Publish on a topic of the robot that the bridge subscribes to."""
    async with (
        connect(sensed.router, dialect=RmwZenoh()) as system,
        system.node("sensor", "/rover") as node,
        node.publishing(topic, kind) as publication,
    ):
        with anyio.fail_after(30.0):
            await publication.wait_for_subscription()
        yield publication


def wrench(*force: float) -> dict[str, Any]:
    return {"header": {"frame_id": "tool0"}, "wrench": {"force": dict(zip("xyz", force, strict=True))}}


def detections(name: str, score: float, width: float, height: float, identifier: str = "") -> dict[str, Any]:
    found = {
        "results": [{"hypothesis": {"class_id": name, "score": score}}],
        "bbox": {"size_x": width, "size_y": height},
        "id": identifier,
    }
    return {"header": {"frame_id": "eye"}, "detections": [found]}


async def test_a_force_beyond_the_limit_ends_the_wait(sensed: Sensed) -> None:
    end = Ends()
    async with (
        publishing(sensed, "wrist/wrench", WRENCH) as sensor,
        connect_robots(sensed.endpoint, "a test", robots=("rover",)) as node,
    ):
        sensor.publish(wrench(0.0, 3.0, 4.0))
        await node.watch_force("rover", "wrist", 5.0, end)  # exactly 5 N is not more
        for force in (float("nan"), 4.9, 5.1, 0.0):  # a short peak
            assert end.report is None
            sensor.publish(wrench(force, 0.0, 0.0))
        assert (await end.wait()).status is GoalStatus.SUCCEEDED


async def test_waits_are_refused_with_the_reason(sensed: Sensed) -> None:
    async with connect_robots(sensed.endpoint, "a test", robots=("rover",)) as node:
        with pytest.raises(
            BackendRefused, match=r"unknown force-torque sensor 'eye' \(in the profile of 'rover': "
        ):
            await node.watch_force("rover", "eye", 5.0, Ends())
        with pytest.raises(BackendRefused, match="invalid force nan"):
            await node.watch_force("rover", "wrist", float("nan"), Ends())
        with pytest.raises(BackendRefused, match=r"no measurement .* on /rover/silent/wrench: no publisher"):
            await node.watch_force("rover", "silent", 5.0, Ends())
        with pytest.raises(BackendRefused, match=r"invalid share 1\.5"):
            await node.watch_sight("rover", "eye", "box", 1.5, Ends())
        with pytest.raises(BackendRefused, match="add `width` and `height` to its detector"):
            await node.watch_sight("rover", "other", "box", 0.1, Ends())


@pytest.mark.parametrize(
    ("share", "misses", "hit"),
    [
        (0.0, [("cup", 0.9, 100.0, 100.0), ("box", 0.4, 100.0, 100.0)], ("box", 0.5, 1.0, 1.0)),
        (0.1, [("box", 0.9, 99.0, 20.0)], ("box", 0.9, 100.0, 20.0)),
        (0.1, [("cup", 0.9, 99.0, 20.0, "box")], ("cup", 0.9, 100.0, 20.0, "box")),
    ],
)
async def test_a_detection_ends_the_wait(
    sensed: Sensed, share: float, misses: list[tuple[Any, ...]], hit: tuple[Any, ...]
) -> None:
    end, later = Ends(), Ends()
    async with (
        publishing(sensed, "eye/detections", DETECTIONS) as detector,
        connect_robots(sensed.endpoint, "a test", robots=("rover",)) as node,
    ):
        detector.publish({"detections": []})
        await node.watch_sight("rover", "eye", "box", share, end)
        for missed in misses:
            detector.publish(detections(*missed))
        await node.watch_sight("rover", "eye", "nothing", 0.0, later)  # answered after the messages
        assert end.report is None
        detector.publish(detections(*hit))
        assert (await end.wait()).status is GoalStatus.SUCCEEDED
        assert later.report is None


async def test_a_scenario_waits_for_a_force(sensed: Sensed, tmp_path: Path) -> None:
    async with publishing(sensed, "wrist/wrench", WRENCH) as sensor:
        sensor.publish(wrench(0.0, 0.0, -30.0))
        text = SCENARIO + "        tb.wait_for_force('wrist', above: 20N)\n"
        assert (await run_on_robot(tmp_path, text, sensed.endpoint, "tb", "rover")).status is RunStatus.PASSED


@pytest.mark.parametrize(
    ("action", "verb"),
    [("wait_for_force('wrist', above: 20N)", "force"), ("wait_until_sees('box', 'eye')", "sight")],
)
async def test_a_robot_without_such_a_topic_is_refused_before_the_run(
    sensed: Sensed, tmp_path: Path, action: str, verb: str
) -> None:
    with pytest.raises(UsageError, match=f"'plain' does not serve `watch_{verb}`; the profile of a ROS 2 robot"):
        await run_on_robot(tmp_path, f"{SCENARIO}        tb.{action}\n", sensed.endpoint, "tb", "plain")


def test_a_detector_has_both_sizes_or_none() -> None:
    assert Detector(topic="a").area is None
    with pytest.raises(ValueError, match="expected both `width` and `height`"):
        Detector(topic="a", width=3)
