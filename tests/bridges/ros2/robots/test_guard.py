"""Guards of bridges: ROS 2 robots stop when their bridge dies or hangs, and orphaned goals are canceled."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterator
from contextlib import AbstractAsyncContextManager, AsyncExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.action_server import GoalEnd, serving_action
from seoro.bridges.ros2.clients.cancellation import CANCEL_GOAL
from seoro.bridges.ros2.clients.goal_ids import new_goal_id, session_digest
from seoro.bridges.ros2.clients.goals import Goal, sending_goal
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import RosNode, RosOptions, connect
from seoro.bridges.ros2.robots.guard import (
    ALARM,
    ALARMS,
    END,
    HEARTBEAT,
    PENDING,
    GuardSettings,
    encode_alarms,
    guard,
    watch_heartbeats,
)
from seoro.bridges.ros2.robots.guard_state import GuardState
from seoro.bridges.ros2.robots.guarded import Heartbeats
from seoro.bridges.ros2.robots.orphaned_goals import GONE_FOR, STATUSES, GoalSenders
from seoro.bridges.ros2.robots.profile import Arm, BridgedRobot, Profile
from seoro.bridges.ros2.wire import LATCHED
from seoro.bridges.session import open_session
from tests.bridges.ros2.robots.conftest import BRIDGE, FAKE_ROBOT, Bridged
from tests.bridges.ros2.robots.test_safety import (
    DEADLINE,
    DRIVER,
    drives,
    goal_ended,
    has_goal,
    shortest,
    wait_for,
)
from tests.bridges.ros2.systems import two_nodes
from tests.routers import free_endpoint, process, router_process

SEORO = "import sys; from seoro.cli.main import main; sys.exit(main(sys.argv[1:]))"
SPIN = "nav2_msgs/action/Spin"
NAVIGATE = "nav2_msgs/action/NavigateToPose"
FAR = {"pose": {"pose": {"position": {"x": 90.0}}}}


@dataclass(frozen=True)
class Alone:
    """A robot of one test with its notes, router and bridge."""

    bridged: Bridged
    router: str
    bridge: subprocess.Popen[bytes]


@contextmanager
def alone(folder: Path) -> Iterator[Alone]:
    router, endpoint = free_endpoint(), f"unixsock-stream/{folder}/bridge"
    with (
        router_process(router),
        process(str(FAKE_ROBOT), str(folder), router, "tb", "geometry_msgs/msg/Twist"),
        process("-c", BRIDGE, router, endpoint, "tb") as bridge,
    ):
        yield Alone(Bridged(endpoint, folder / "tb"), router, bridge)


def guard_of(bridge: subprocess.Popen[bytes]) -> int:
    """Return the process of the guard of a bridge."""
    [child] = Path(f"/proc/{bridge.pid}/task/{bridge.pid}/children").read_text().split()
    return int(child)


def ended(number: int) -> float | None:
    """Return the time if a process has ended, even if its parent has not read its status."""
    with suppress(FileNotFoundError):
        state = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0]
        return time.monotonic() if state == "Z" else None
    return time.monotonic()


@pytest.mark.more
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
@pytest.mark.parametrize(
    ("how", "begun", "over"), [("velocity", drives, Bridged.stopped), ("goal", has_goal, goal_ended)]
)
def test_robots_stop_with_their_bridge(
    how: str,
    begun: Callable[[Bridged], float | None],
    over: Callable[[Bridged], float | None],
    number: signal.Signals,
    tmp_path: Path,
) -> None:
    def measured() -> float:
        folder = Path(mkdtemp(dir=tmp_path))
        with alone(folder) as robot, process(DRIVER, robot.bridged.endpoint, "tb", how):
            wait_for(time.monotonic(), lambda: begun(robot.bridged))
            guard = guard_of(robot.bridge)
            time.sleep(0.1)  # until the bridge has the answer to its goal; the guard waits for its end
            moment = time.monotonic()
            robot.bridge.send_signal(number)
            passed = wait_for(moment, lambda: over(robot.bridged))
            robot.bridge.kill()
            wait_for(time.monotonic(), lambda: ended(guard))
            return passed

    assert shortest(measured) < DEADLINE


@pytest.mark.more
def test_the_next_bridge_cancels_orphaned_goals(tmp_path: Path) -> None:
    with alone(tmp_path) as robot, process(DRIVER, robot.bridged.endpoint, "tb", "goal"):
        wait_for(time.monotonic(), lambda: has_goal(robot.bridged))
        os.kill(guard_of(robot.bridge), signal.SIGKILL)
        robot.bridge.kill()
        time.sleep(0.5)
        assert goal_ended(robot.bridged) is None
        with process("-c", BRIDGE, robot.router, f"unixsock-stream/{tmp_path}/next", "tb"):
            wait_for(time.monotonic(), lambda: goal_ended(robot.bridged))


@pytest.mark.more
def test_a_bridge_cancels_orphaned_goals_of_other_clients(tmp_path: Path) -> None:
    send = ["ros", "action", "send_goal", "/tb/navigate_to_pose", "{pose: {pose: {position: {x: 90.0}}}}"]
    with alone(tmp_path) as robot:
        command = [sys.executable, "-c", SEORO, *send, "--ros", robot.router]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL) as sender:
            while has_goal(robot.bridged) is None:
                assert sender.poll() is None
                time.sleep(0.02)
            sender.kill()
        wait_for(time.monotonic() + GONE_FOR, lambda: goal_ended(robot.bridged))


@pytest.mark.more
async def test_a_guard_without_a_connection_regards_no_sender_as_gone(tmp_path: Path, types: TypeStore) -> None:
    router = f"unixsock-stream/{tmp_path}/router"
    hub = AsyncExitStack()
    await hub.enter_async_context(open_session(listen=router, gossip=True))
    async with two_nodes(router, types) as (there, here), serving_action(there, "/spin", SPIN, wait_forever):
        senders = GoalSenders(here.graph)
        sender = session_digest(there.node.session)
        await here.graph.wait_for(lambda seen: seen.action_servers("/spin"), 30.0)
        await hub.aclose()
        with anyio.move_on_after(GONE_FOR + 0.5) as waiting:
            await senders.wait_gone(sender, "/spin")
        assert waiting.cancelled_caught
        async with open_session(listen=router, gossip=True):
            with anyio.move_on_after(GONE_FOR + 2.0) as waiting:
                await senders.wait_gone(sender, "/spin")
            assert waiting.cancelled_caught
            assert here.graph.action_servers("/spin")
            senders.disown(there.node.session, ["/spin"])
            with anyio.fail_after(1.0):
                await senders.wait_gone(sender, "/spin")


@pytest.mark.more
async def test_goals_of_running_clients_are_not_canceled(tmp_path: Path) -> None:
    with alone(tmp_path) as robot:
        async with connect(robot.router) as system, system.node("else") as node, far_away(node):
            await anyio.sleep(1.5)
            assert goal_ended(robot.bridged) is None


@pytest.mark.more
async def test_goals_without_a_known_sender_are_not_canceled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.bridges.ros2.clients.goals.new_goal_id", lambda _session: bytes(range(16)))
    monkeypatch.setattr("seoro.bridges.ros2.clients.goals.Goal.cancel", leave)
    with alone(tmp_path) as robot:
        async with connect(robot.router) as system, system.node("else") as node, far_away(node):
            pass
        await anyio.sleep(1.5)
        assert [value for _, value in robot.bridged.notes("goal")] == [1.0]


def far_away(node: RosNode) -> AbstractAsyncContextManager[Goal]:
    """Send a goal that the robot does not reach."""
    return sending_goal(node, "/tb/navigate_to_pose", NAVIGATE, FAR, lambda _: None)


async def wait_forever(_goal: object) -> GoalEnd:
    """Execute a goal endlessly."""
    await anyio.sleep_forever()
    raise AssertionError


async def leave(_goal: Goal) -> None:
    """Do not cancel a goal."""


@pytest.mark.more
def test_a_dead_guard_is_restarted(tmp_path: Path) -> None:
    with alone(tmp_path) as robot:
        first = guard_of(robot.bridge)
        os.kill(first, signal.SIGKILL)

        def started() -> float | None:
            with suppress(ValueError):
                return None if guard_of(robot.bridge) == first else time.monotonic()
            return None

        wait_for(time.monotonic() + 2.0, started)
        robot.bridge.kill()


@pytest.mark.parametrize("last", [END, b""])
async def test_missing_heartbeats_stop_robots_until_they_resume(
    last: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.bridges.ros2.robots.guard.SILENCE", 0.02)
    received: list[str] = []
    ours, theirs = os.pipe()

    def stop(robots: Collection[int], why: str) -> None:
        assert set(robots) == {0}
        received.append(why)
        os.write(theirs, HEARTBEAT)

    def resume(_robots: Collection[int]) -> None:
        received.append("goes on")
        os.write(theirs, last)
        os.close(theirs)

    with anyio.fail_after(30.0):
        assert await watch_heartbeats(ours, 1, stop, resume) == (last or HEARTBEAT)
    os.close(ours)
    assert received == ["has sent no heartbeat for 0.02 s", "goes on"]


async def test_an_alarm_stops_its_robots_until_the_bridge_has_stopped_them() -> None:
    received: list[tuple[str, set[int]]] = []
    names = ("first", "second", "third")
    second, third = encode_alarms(names, {"second"}), encode_alarms(names, {"third"})
    ours, theirs = os.pipe()
    signs = iter([second + second, second + third, third + HEARTBEAT + third, third, HEARTBEAT, END])

    def write() -> None:
        os.write(theirs, next(signs))

    def stop(robots: Collection[int], why: str) -> None:
        received.append((why, set(robots)))

    def resume(robots: Collection[int]) -> None:
        received.append(("over", set(robots)))

    async def write_all() -> None:
        with suppress(StopIteration):
            while True:
                write()
                await until_read(ours)

    with anyio.fail_after(30.0):
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(write_all)
            assert await watch_heartbeats(ours, len(names), stop, resume) == END
            tasks.cancel_scope.cancel()
    os.close(ours)
    os.close(theirs)
    why = "has to stop robots in an emergency"
    assert received == [(why, {1}), (why, {2}), ("over", {1}), ("over", {2})]


async def until_read(pipe: int) -> None:
    while select.select([pipe], [], [], 0.0)[0]:
        await anyio.sleep(0.0)


def test_robots_beyond_the_number_of_alarms_share_one() -> None:
    names = [str(number) for number in range(ALARMS + 2)]
    assert encode_alarms(names, {"1", str(ALARMS + 1)}) == bytes([ALARM | 1])
    assert encode_alarms(names, ()) == b""


async def test_a_briefly_busy_event_loop_keeps_sending_heartbeats(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.bridges.ros2.robots.guarded.PERIOD", 0.001)
    monkeypatch.setattr("seoro.bridges.ros2.robots.guarded.PATIENCE", 0.1)
    theirs, ours = os.pipe()
    os.set_blocking(theirs, False)
    state = GuardState()
    heartbeats = Heartbeats(ours, state, ("spot",))

    def given() -> int:
        with suppress(BlockingIOError):
            return len(os.read(theirs, 1 << 16))
        return 0

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(heartbeats.watch_loop)
        await anyio.sleep(0.01)
        given()
        block(0.05)
        assert given() > 5
        block(0.2)
        given()
        block(0.05)
        assert given() == 0
        await anyio.sleep(0.02)
        assert given() > 0
        tasks.cancel_scope.cancel()
    given()
    state.add_unanswered()
    state.remove_unanswered()
    assert PENDING + HEARTBEAT in os.read(theirs, 1 << 16)
    heartbeats.end()
    assert os.read(theirs, 1 << 16).endswith(END)
    os.close(theirs)


async def test_a_goal_accepted_after_the_death_of_its_bridge_is_canceled(
    router: str, types: TypeStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.bridges.ros2.robots.guard.STOPPING", 0.01)
    ready, canceled = anyio.Event(), anyio.Event()

    async def cancel_goal(request: Any) -> dict[str, Any]:
        canceled.set()
        return {"goals_canceling": [request.goal_info]}

    theirs, ours = os.pipe()
    async with (
        two_nodes(router, types) as (there, _),
        there.serving("/spin/_action/cancel_goal", CANCEL_GOAL, cancel_goal),
        there.publishing("/spin/_action/status", STATUSES, LATCHED) as statuses,
        anyio.create_task_group() as tasks,
    ):
        profile = Profile(model="spot", kinds=("robot",), arm=Arm(joints={"waist": 1.0}, trajectory="spin"))
        ros = RosOptions(router, dialect="rmw_zenoh")
        settings = GuardSettings(ros=ros, session="gone", robots=(BridgedRobot("spot", profile),))

        async def guarding() -> None:
            await guard(settings, theirs, ready.set)
            assert canceled.is_set()

        tasks.start_soon(guarding)
        with anyio.fail_after(30.0):
            await ready.wait()
            os.write(ours, HEARTBEAT + PENDING)
            os.close(ours)
            await anyio.sleep(0.3)  # time in which the guard would end
            goal = {"goal_id": {"uuid": list(new_goal_id("gone"))}}
            statuses.publish({"status_list": [{"goal_info": goal, "status": 2}]})
            await canceled.wait()
        tasks.cancel_scope.cancel()
    os.close(theirs)


def block(duration: float) -> None:
    """Block the event loop."""
    threading.Event().wait(duration)
