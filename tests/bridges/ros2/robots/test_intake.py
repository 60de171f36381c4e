"""Messages of robots are read in batches, and as they arrive while a task waits."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, nullcontext
from functools import partial
from pathlib import Path

import anyio
import pytest

from seoro.bridges.robot.connecting import connect_robots
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import RosOptions
from seoro.bridges.ros2.robots import intake as module
from seoro.bridges.ros2.robots.guard_state import GuardState
from seoro.bridges.ros2.robots.intake import Intake
from seoro.bridges.ros2.robots.profile import BridgedRobot, read_profile
from seoro.bridges.ros2.robots.running import BridgeOptions, bridging
from seoro.bridges.ros2.robots.velocity import Velocity
from seoro.bridges.ros2.topics import ReceivedPayload, Subscription
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.bridges.session import Bound, Sample
from seoro.concurrency.background import background
from tests.bridges.robot.test_connecting import Ends
from tests.bridges.ros2.robots.test_ending import Commands
from tests.bridges.ros2.systems import two_nodes

pytestmark = pytest.mark.anyio

STRING = "std_msgs/msg/String"
DEADLINE = 30.0  # [s]


class Stage:
    """An intake of two topics, and the messages that it has taken."""

    def __init__(self, types: TypeStore) -> None:
        self.intake = Intake()
        self.taken: list[tuple[str, bytes]] = []
        self.topics = [Subscription(name, STRING, Bound(100), RmwZenoh(), types) for name in ("/a", "/b")]
        for topic in self.topics:
            self.intake.add(topic, partial(self._take, topic.topic))

    def _take(self, topic: str, received: ReceivedPayload) -> None:
        self.taken.append((topic, received.payload))

    def arrive(self, topic: int, payload: bytes) -> None:
        """Let a message arrive, as a thread of Zenoh does."""
        self.topics[topic].on_sample(Sample("0/a/type/hash", payload, b"", 0))


@asynccontextmanager
async def staged(types: TypeStore) -> AsyncIterator[Stage]:
    """Yield a stage whose intake is running."""
    async with background() as tasks:
        stage = Stage(types)
        tasks.start_soon(stage.intake.run)
        await anyio.wait_all_tasks_blocked()
        yield stage


@pytest.fixture
def _seldom(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let an intake read on demand only."""
    monkeypatch.setattr(module, "PERIOD", 2 * DEADLINE)


@pytest.mark.usefixtures("_seldom")
async def test_messages_wait_until_they_are_read(types: TypeStore) -> None:
    async with staged(types) as stage:
        stage.arrive(0, b"1")
        await anyio.wait_all_tasks_blocked()
        assert stage.taken == []
        stage.arrive(1, b"2")
        stage.arrive(0, b"3")
        stage.intake.read()
        assert stage.taken == [("/a", b"1"), ("/a", b"3"), ("/b", b"2")]


async def test_messages_are_read_after_a_period(types: TypeStore, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "PERIOD", 0.0)
    async with staged(types) as stage:
        stage.arrive(1, b"1")
        with anyio.fail_after(DEADLINE):
            while not stage.taken:
                await asyncio.sleep(0)
    assert stage.taken == [("/b", b"1")]


@pytest.mark.usefixtures("_seldom")
async def test_a_waiting_task_sees_messages_as_they_arrive(types: TypeStore) -> None:
    async with staged(types) as stage:

        async def wait_for(count: int) -> None:
            await stage.intake.arrivals.wait_for(lambda: len(stage.taken) >= count)

        stage.arrive(0, b"before")
        with anyio.fail_after(DEADLINE):
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(wait_for, 3)
                await wait_for(1)
                for payload in (b"1", b"2"):
                    await anyio.wait_all_tasks_blocked()
                    await anyio.to_thread.run_sync(stage.arrive, 1, payload)
        assert stage.taken == [("/a", b"before"), ("/b", b"1"), ("/b", b"2")]


@pytest.mark.usefixtures("_seldom")
async def test_velocities_do_not_wait_for_the_reading_of_messages(
    router: str, types: TypeStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[str] = []
    read, command = Intake.read, Velocity.command

    def noted_read(intake: Intake) -> None:
        done.append("read")
        read(intake)

    def noted_command(velocity: Velocity, linear: float, angular: float, duration: float) -> None:
        done.append(f"command {linear}")
        command(velocity, linear, angular, duration)

    monkeypatch.setattr(Intake, "read", noted_read)
    monkeypatch.setattr(Velocity, "command", noted_command)
    monkeypatch.setattr("seoro.bridges.ros2.robots.running.guarded", lambda _: nullcontext(GuardState()))
    endpoint, commands = f"unixsock-stream/{tmp_path}/bridge", Commands()
    robot = BridgedRobot("tb", read_profile("turtlebot4"), "/tb")
    async with two_nodes(router, types) as (base, _), anyio.create_task_group() as tasks:
        await tasks.start(commands.take, base)
        async with (
            bridging(BridgeOptions([robot], RosOptions(router), listen=endpoint)),
            connect_robots(endpoint, "a test") as node,
        ):
            end = Ends()
            await node.drive("tb", 0.1, 0.0, 0.01, end)  # the bridge knows the subscription by then
            await end.wait()
            done.clear()
            await node.drive("tb", 0.2, 0.0, 60.0, Ends())
            assert done == ["command 0.2"]
        tasks.cancel_scope.cancel()
