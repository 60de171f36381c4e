"""Checks of robots behind a bridge."""

from __future__ import annotations

import time
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from functools import partial
from pathlib import Path
from typing import Any

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.ros2.interfaces import Message, TypeStore
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.robots import checks
from seoro.bridges.ros2.topics import Publication
from seoro.bridges.ros2.wire import Durability, Qos, Reliability
from seoro.concurrency.background import background
from tests.bridges.ros2.robots.test_types import served
from tests.bridges.ros2.systems import two_nodes

pytestmark = pytest.mark.anyio

TWIST, ODOMETRY, TF = "geometry_msgs/msg/Twist", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"
POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"
NAVIGATE = "nav2_msgs/action/NavigateToPose"
DEADLINE = 30.0  # [s]
BARE = """model: bare
kinds: [robot]
base:
  limits: {linear: 0.5, angular: 1.0}
"""
Checked = list[tuple[bool, str]]


@pytest.fixture(autouse=True)
def _soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shorten the wait for messages that do not arrive."""
    monkeypatch.setattr(checks, "MESSAGE_TIMEOUT", 0.3)


class Robot:
    """Robot in a system, made of its endpoints."""

    def __init__(self, there: RosNode, here: RosNode, stack: AsyncExitStack, profile: Path) -> None:
        self.there = there
        self._here = here
        self._stack = stack
        self._profile = profile

    async def has(self, *topics: tuple[str, str], qos: Qos | None = None) -> list[Publication]:
        """Add publishers."""
        return [await self._stack.enter_async_context(self.there.publishing(*each, qos)) for each in topics]

    async def subscribes(self, topic: str, type_name: str, qos: Qos | None = None) -> None:
        await self._stack.enter_async_context(self.there.subscribing(topic, type_name, qos))

    async def serves(self, service: str, type_name: str, response: Mapping[str, Any] | None = None) -> None:
        async def handle(_: Message) -> Mapping[str, Any]:
            return response or {}

        await self._stack.enter_async_context(self.there.serving(service, type_name, handle))

    async def navigates(self) -> None:
        await self.serves("/navigate_to_pose/_action/send_goal", f"{NAVIGATE}_SendGoal")

    async def drives(self, stamp: float | None = None) -> None:
        """Add all of a base that drives and navigates, with odometry of a stamp [s since 1970] or of the time."""
        await self.subscribes("/cmd_vel", TWIST)
        await self.subscribes("/initialpose", POSE)
        await self.has(("/amcl_pose", POSE), qos=Qos(durability=Durability.TRANSIENT_LOCAL, depth=1))
        await self.navigates()
        odometry, transforms = await self.has(("/odom", ODOMETRY), ("/tf", TF))
        tasks = await self._stack.enter_async_context(background())

        async def publish() -> None:
            while True:
                moment = time.time() if stamp is None else stamp
                odometry.publish({"header": {"stamp": {"sec": int(moment)}, "frame_id": "odom"}})
                transforms.publish({"transforms": []})
                await anyio.sleep(0.02)

        tasks.start_soon(publish)

    async def check(self, count: int) -> Checked:
        """Return the problems once the bridge sees a number of endpoints: severity and text."""
        with anyio.fail_after(DEADLINE):
            await self._here.graph.wait_for(lambda graph: len(self._here.others(graph.endpoints())) >= count)
            async with served(self._here, str(self._profile)) as robot:
                found = await robot.handlers[wire.CHECK_ROBOT](wire.RobotName(robot="tb"))
        assert isinstance(found, wire.RobotCheck)
        assert all(problem.help for problem in found.problems)
        return [(problem.is_fatal, f"{problem.text} = {problem.help}") for problem in found.problems]


@asynccontextmanager
async def robot_with(profile: str, router: str, types: TypeStore, folder: Path) -> AsyncIterator[Robot]:
    file = folder / "profile.yaml"
    file.write_text(profile)
    async with two_nodes(router, types) as (there, here), AsyncExitStack() as stack:
        yield Robot(there, here, stack, file)


Base = Callable[[], AbstractAsyncContextManager[Robot]]


@pytest.fixture
def base(router: str, types: TypeStore, tmp_path: Path) -> Base:
    """Return the context of a robot whose profile has a base."""
    return partial(robot_with, BARE, router, types, tmp_path)


def one(found: Checked, text: str) -> tuple[bool, str]:
    """Return the only problem with a text."""
    [problem] = [each for each in found if text in each[1]]
    return problem


async def test_a_robot_that_is_well_has_no_problems(base: Base) -> None:
    async with base() as robot:
        await robot.drives()
        assert await robot.check(6) == []


async def test_missing_parts_are_named(base: Base) -> None:
    async with base() as robot:
        await robot.subscribes("/tb1/cmd_vel", TWIST)
        found = await robot.check(1)
        assert [(is_fatal, text.partition(" = ")[0]) for is_fatal, text in found] == [
            (True, "no subscription to /cmd_vel: the driver of the base is not running"),
            (True, "no publisher of /odom: the odometry of the base is not running"),
            (False, "no subscription to /initialpose: the localisation is not running"),
            (False, "no publisher of /amcl_pose: the localisation is not running"),
            (False, "no server of /navigate_to_pose: the navigation is not running"),
            (False, "no publisher of /tf: the publisher of transforms is not running"),
        ]
        assert one(found, "/cmd_vel: ")[1].endswith("correct `base.cmd_vel` in the profile; found: /tb1/cmd_vel")


async def test_silent_streams_are_named(base: Base) -> None:
    async with base() as robot:
        await robot.has(("/odom", ODOMETRY))
        assert one(await robot.check(1), "/odom") == (
            True,
            "no message on /odom within 0.3 s: no message has arrived = check the odometry of the base (/robot)",
        )


async def test_other_types_are_named(base: Base) -> None:
    async with base() as robot:
        await robot.subscribes("/cmd_vel", "std_msgs/msg/String")
        is_fatal, text = one(await robot.check(1), "/cmd_vel")
        assert is_fatal
        assert text.startswith(f"/cmd_vel has the type std_msgs/msg/String, expected {TWIST} or {TWIST}Stamped = ")


async def test_different_qos_profiles_are_warnings(base: Base) -> None:
    async with base() as robot:
        await robot.subscribes("/cmd_vel", TWIST, Qos(durability=Durability.TRANSIENT_LOCAL, depth=1))
        await robot.has(("/amcl_pose", POSE), qos=Qos(Reliability.BEST_EFFORT, Durability.VOLATILE))
        found = await robot.check(2)
        assert one(found, "QoS of /cmd_vel: volatile is offered, transient_local is requested")[0] is False
        assert one(found, "QoS of /amcl_pose: best_effort is offered, reliable is requested")[0] is False


@pytest.mark.parametrize(("stamp", "text"), [(-100.0, "behind"), (100.0, "ahead of")])
async def test_stamps_of_another_time_are_warnings(base: Base, stamp: float, text: str) -> None:
    async with base() as robot:
        await robot.drives(time.time() + stamp)
        [(is_fatal, found)] = await robot.check(6)
        assert not is_fatal
        assert found.startswith("stamps on /odom are ")
        assert f" s {text} the clock = " in found


async def test_simulated_time_without_a_clock_is_fatal(base: Base) -> None:
    async with base() as robot:
        await robot.drives()
        await serve_sim_time(robot, is_simulated=True)
        assert await robot.check(8) == [
            (
                True,
                "the simulated time of /robot stands still: /clock has no publisher = start the simulator, or set "
                "`use_sim_time` to false",
            )
        ]


async def test_real_time_beside_a_clock_is_a_warning(base: Base) -> None:
    async with base() as robot:
        await robot.drives()
        await serve_sim_time(robot, is_simulated=False)
        await robot.has(("/clock", "rosgraph_msgs/msg/Clock"))
        [(is_fatal, text)] = await robot.check(9)
        assert not is_fatal
        assert text.startswith("/clock is published, but `use_sim_time` is false of /robot")


async def serve_sim_time(robot: Robot, *, is_simulated: bool) -> None:
    services: Sequence[tuple[str, Mapping[str, Any]]] = (
        ("GetParameters", {"values": [{"type": 1, "bool_value": is_simulated}]}),
        ("ListParameters", {"result": {"names": ["use_sim_time"]}}),
    )
    for (kind, response), name in zip(services, ("get_parameters", "list_parameters"), strict=True):
        await robot.serves(f"/robot/{name}", f"rcl_interfaces/srv/{kind}", response)


async def test_inactive_navigation_is_a_warning(base: Base) -> None:
    async with base() as robot:
        await robot.drives()
        state = {"current_state": {"id": 2, "label": "inactive"}}
        await robot.serves("/robot/get_state", "lifecycle_msgs/srv/GetState", state)
        [(is_fatal, text)] = await robot.check(7)
        assert not is_fatal
        assert text.startswith("the navigation (/robot) is inactive, expected active = activate it")


CELL = """model: cell
kinds: [arm, robot]
battery: power
arm:
  joints: {elbow: 1.0, wrist: 1.0}
  trajectory: controller/follow_joint_trajectory
  move_group: {group: arm}
sensors:
  force: {wrist: wrench}
"""


async def test_parts_of_arms_and_sensors_are_named(router: str, types: TypeStore, tmp_path: Path) -> None:
    async with robot_with(CELL, router, types, tmp_path) as cell:
        [states] = await cell.has(("/joint_states", "sensor_msgs/msg/JointState"))
        async with background() as tasks:

            async def publish() -> None:
                while True:
                    states.publish({"name": ["elbow", "finger"], "position": [0.0, 0.0]})
                    await anyio.sleep(0.02)

            tasks.start_soon(publish)
            found = await cell.check(1)
    assert [(is_fatal, text.partition(" = ")[0]) for is_fatal, text in found] == [
        (True, "no server of /controller/follow_joint_trajectory: the controller of the arm is not running"),
        (True, "no server of /move_action: MoveIt is not running"),
        (False, "no publisher of /tf: the publisher of transforms is not running"),
        (False, "no publisher of /power: the driver of the battery is not running"),
        (False, "no publisher of /wrench: the sensor 'wrist' is not running"),
        (True, "/joint_states lacks the joints wrist; it has elbow, finger"),
    ]
