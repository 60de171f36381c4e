"""Topics with conflicting types: the bridge continues, and reports them."""

from __future__ import annotations

import logging
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager, suppress

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.robots.link import Link, RobotLink
from seoro.bridges.ros2.robots.profile import read_profile
from seoro.bridges.ros2.robots.robot import RosRobot
from seoro.bridges.serving.event_log import EventLog
from seoro.bridges.serving.work import Work
from seoro.bridges.wire.refusal import RequestRefused
from seoro.concurrency.background import background
from tests.bridges.ros2.systems import two_nodes

pytestmark = pytest.mark.anyio

TWIST, STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"
POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"
NUMBER = "std_msgs/msg/Float32"
DEADLINE = 30.0  # [s]
FORWARD = wire.CmdVel(robot="tb", twist=wire.Twist(linear=wire.Vector3(x=0.1), angular=wire.Vector3()))


@asynccontextmanager
async def served(
    here: RosNode, profile: str = "turtlebot4", events: EventLog | None = None
) -> AsyncIterator[RosRobot]:
    """Yield a robot that a bridge serves."""
    async with AsyncExitStack() as stack, background() as tasks:
        events = events or EventLog()
        link = RobotLink(here, stack, tasks, name="tb", work=Work(tasks, events), events=events)
        robot = RosRobot(read_profile(profile), link)
        await robot.open()
        yield robot


async def until_said(caplog: pytest.LogCaptureFixture, text: str) -> None:
    with anyio.fail_after(DEADLINE):
        while text not in caplog.text:
            await anyio.sleep(0.01)


@pytest.fixture
def _soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shorten the wait for missing endpoints."""
    for module in ("velocity", "localisation"):
        monkeypatch.setattr(f"seoro.bridges.ros2.robots.{module}.DISCOVERY_TIMEOUT", 0.05)


@pytest.mark.usefixtures("_soon")
@pytest.mark.parametrize("when", ["before the bridge", "after it"])
async def test_a_base_is_driven_once_no_velocity_topic_has_another_type(
    when: str, router: str, types: TypeStore, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING)
    problem = f"/cmd_vel is of type {TWIST}, not {STAMPED}"
    async with two_nodes(router, types) as (there, here), AsyncExitStack() as others:

        async def come() -> None:
            await others.enter_async_context(there.publishing("/cmd_vel", TWIST))
            await here.graph.wait_for(lambda graph: graph.publishers("/cmd_vel"), DEADLINE)

        if when == "before the bridge":
            await come()
        async with served(here) as robot:
            if when == "after it":
                await come()
            async with there.subscribing("/cmd_vel", STAMPED) as commands:
                await until_said(caplog, problem)
                with pytest.raises(RequestRefused, match=problem):
                    await robot.handlers[wire.CMD_VEL](FORWARD)
                await others.aclose()
                with anyio.fail_after(DEADLINE):
                    await until_taken(robot)
                    assert (await commands.message()).twist.linear.x == 0.1
    assert caplog.text.count(problem) == 1


@pytest.mark.usefixtures("_soon")
async def test_a_base_that_returns_with_another_type_is_driven_by_that_type(router: str, types: TypeStore) -> None:
    async with two_nodes(router, types) as (there, here), served(here) as robot:
        for type_name in (TWIST, STAMPED, TWIST):
            async with there.subscribing("/cmd_vel", type_name, is_checked=False) as commands:
                with anyio.fail_after(DEADLINE):
                    await until_taken(robot)
                    message = await commands.message()
                    assert (message if type_name == TWIST else message.twist).linear.x == 0.1
            await here.graph.wait_for(lambda graph: not graph.subscriptions("/cmd_vel"), DEADLINE)
            with pytest.raises(RequestRefused, match="no subscription to /cmd_vel on the robot"):
                await robot.handlers[wire.CMD_VEL](FORWARD)


async def test_the_charge_of_a_battery_is_dropped_with_its_publisher(router: str, types: TypeStore) -> None:
    async with two_nodes(router, types) as (there, here), served(here) as robot:
        with anyio.fail_after(DEADLINE):
            async with there.publishing("/battery_state", "sensor_msgs/msg/BatteryState") as battery:
                await battery.wait_for_subscription()
                battery.publish({"percentage": 0.5})
                while robot.health.battery != 0.5:
                    await anyio.sleep(0.01)
            while robot.health.battery is not None:
                await anyio.sleep(0.01)
        assert robot.health.battery is None


async def until_taken(robot: RosRobot) -> None:
    """Command a velocity until it is accepted."""
    while True:
        with suppress(RequestRefused):
            await robot.handlers[wire.CMD_VEL](FORWARD)
            return


@pytest.mark.usefixtures("_soon")
async def test_topics_of_another_type_do_not_end_the_bridge(
    router: str, types: TypeStore, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING)
    topics = ("/battery_state", "/amcl_pose", "/initialpose", "/odom")
    async with two_nodes(router, types) as (there, here), AsyncExitStack() as others:
        for topic in topics:
            await others.enter_async_context(there.publishing(topic, NUMBER))
        await here.graph.wait_for(lambda graph: all(graph.publishers(each) for each in topics), DEADLINE)
        async with served(here) as robot:
            for topic in topics:
                await until_said(caplog, topic)
            request = wire.SetInitialPose(robot="tb", pose=wire.Pose3D())
            with pytest.raises(RequestRefused, match=f"/initialpose is of type {NUMBER}, not {POSE}"):
                await robot.handlers[wire.SET_INITIAL_POSE](request)
            await others.aclose()
            battery = there.publishing("/battery_state", "sensor_msgs/msg/BatteryState")
            async with battery as publication:
                await publication.wait_for_subscription(DEADLINE)
                publication.publish({"percentage": 0.5})
                with anyio.fail_after(DEADLINE):
                    while robot.health.battery != 0.5:
                        await anyio.sleep(0.01)
    for topic in topics:
        assert sum(topic in record.getMessage() for record in caplog.records) == 1


async def test_a_service_of_another_type_is_refused(router: str, types: TypeStore) -> None:
    async def respond(_request: object) -> dict[str, object]:
        return {}

    async with (
        two_nodes(router, types) as (robot, here),
        robot.serving("/clear", "std_srvs/srv/Trigger", respond),
        AsyncExitStack() as stack,
        background() as tasks,
    ):
        await here.graph.wait_for(lambda graph: graph.servers("/clear"))
        with pytest.raises(RequestRefused, match=r"std_srvs/srv/Trigger"):
            await Link(here, stack, tasks).call("/clear", "std_srvs/srv/Empty", {})
