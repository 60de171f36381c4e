"""Robots behind a bridge as a backend, with a bridge in another process."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import anyio
import pytest

from seoro.bridges.robot.connecting import RobotsBusy, connect_robots
from seoro.errors import BackendError, BackendRefused, BackendUnreachable
from seoro.robotics.geometry import Pose3D, Position3D
from seoro.runtime.contracts.backends import GoalStatus, Report
from seoro.runtime.contracts.tracks import PoseSample, Sample, SceneChange
from tests.bridges.robot.conftest import Rails

pytestmark = pytest.mark.anyio


class Ends:
    """A reporter that can be waited for."""

    def __init__(self) -> None:
        self.report: Report | None = None
        self._told = anyio.Event()

    def __call__(self, report: Report) -> None:
        self.report = report
        self._told.set()

    async def wait(self) -> Report:
        with anyio.fail_after(30.0):
            await self._told.wait()
        assert self.report is not None
        return self.report


def at(x: float) -> Pose3D:
    return Pose3D(Position3D(x=x))


async def test_a_goal_is_reached_and_reported(rails: Rails) -> None:
    end, near = Ends(), Ends()
    async with connect_robots(rails.endpoint, "a test") as node:
        await node.watch_proximity("line", "base_link", "map", Position3D(x=0.05), 0.01, near)
        await node.navigate("line", [at(0.1)], stop_at_each=False, report=end)
        assert (await near.wait()).status is GoalStatus.SUCCEEDED
        assert await end.wait() == Report(GoalStatus.SUCCEEDED, "on rails")
    assert [velocity for _, _, velocity in rails.commands()][:3] == [0.0, 0.5, 0.0]


async def test_aborted_and_refused_goals_have_a_reason(rails: Rails) -> None:
    end = Ends()
    async with connect_robots(rails.endpoint, "a test") as node:
        await node.navigate("line", [at(-1.0)], stop_at_each=False, report=end)
        assert await end.wait() == Report(GoalStatus.ABORTED, "the rails end at 0 m")
        with pytest.raises(BackendRefused, match="the rails end at 100 m"):
            await node.navigate("line", [at(200.0)], stop_at_each=False, report=end)
        with pytest.raises(BackendRefused, match=r"unknown robot 'train' .robots: line"):
            await node.navigate("train", [at(1.0)], stop_at_each=False, report=end)
        with pytest.raises(BackendRefused, match="unsupported verb 'get_arm_state'"):
            await node.arm_state("line")


async def test_poses_are_reported_while_robots_move(rails: Rails) -> None:
    end = Ends()
    found: list[Sample] = []
    async with connect_robots(rails.endpoint, "a test") as node:
        await node.set_initial_pose("line", at(0.0))
        await node.start_tracks(50.0, found.append)
        await node.navigate("line", [at(0.2)], stop_at_each=False, report=end)
        await end.wait()
        with anyio.fail_after(30.0):
            while not _is_at_rest(found):
                await anyio.sleep(0.02)
        await node.end_run()
    first, *samples = found
    assert isinstance(first, SceneChange)
    assert (first.kind, first.fields["entity"]) == (
        "entity",
        {"name": "line", "kind": "robot", "real": True, "shapes": []},
    )
    places = [sample.entities["line"][0] for sample in samples if isinstance(sample, PoseSample)]
    assert places == sorted(places)
    assert len(places) > 3
    assert max(sample.entities["line"][7] for sample in samples if isinstance(sample, PoseSample)) > 0.1


def _is_at_rest(found: list[Sample]) -> bool:
    last = found[-1]
    return isinstance(last, PoseSample) and last.entities["line"][0] >= 0.2 and last.entities["line"][7] == 0.0


async def test_a_robot_has_one_goal_at_a_time_which_can_be_cancelled(rails: Rails) -> None:
    end = Ends()
    async with connect_robots(rails.endpoint, "a test") as node:
        goal = await node.navigate("line", [at(50.0)], stop_at_each=False, report=end)
        with pytest.raises(BackendRefused, match=r"line is driving to goal '.+': cancel it, or wait"):
            await node.drive("line", 0.1, 0.0, 1.0, end)
        await node.cancel_goal(goal)
        assert rails.commands()[-1][2] == 0.0
        await node.drive("line", 0.1, 0.0, 0.05, end)
        assert (await end.wait()).status is GoalStatus.SUCCEEDED


async def test_robots_stand_still_after_a_run(rails: Rails) -> None:
    async with connect_robots(rails.endpoint, "a test") as node:
        await node.navigate("line", [at(50.0)], stop_at_each=False, report=Ends())
    assert rails.commands()[-1][2] == 0.0


async def test_a_robot_is_held_by_one_run_at_a_time(rails: Rails) -> None:
    async with connect_robots(rails.endpoint, "the first run"):
        with pytest.raises(RobotsBusy, match="held by the first run: wait for its end"):
            async with connect_robots(rails.endpoint, "the second run"):
                pass
    async with connect_robots(rails.endpoint, "the second run") as node:
        assert [robot.name for robot in node.robots] == ["line"]


async def test_goals_of_a_client_that_hangs_beyond_the_deadline_are_aborted(rails: Rails) -> None:
    end = Ends()
    async with connect_robots(rails.endpoint, "a test") as node:
        await node.navigate("line", [at(50.0)], stop_at_each=False, report=end)
        started = time.monotonic()
        time.sleep(0.8)  # the event loop hangs, and with it every heartbeat
        assert rails.stopped_after(started) is not None
        report = await end.wait()
        assert report.status is GoalStatus.ABORTED
        assert report.interrupted
        assert "the robots were stopped, a test: no heartbeat for 0.4 s" in report.message
        again = Ends()
        await node.drive("line", 0.1, 0.0, 0.05, again)
        assert (await again.wait()).status is GoalStatus.SUCCEEDED


async def test_the_end_of_the_bridge_is_reported(
    start_rails: Callable[..., Rails], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rails = start_rails("--listen", f"unixsock-stream/{tmp_path}/rails")
    monkeypatch.setattr("seoro.bridges.robot.node.PATIENCE", 0.3)
    lost: list[BackendError] = []
    async with connect_robots(rails.endpoint, "a test") as node:
        await node.start_run(lambda name, arguments: None, lost.append)
        rails.process.kill()
        with anyio.fail_after(30.0):
            while not lost:
                await anyio.sleep(0.05)
    assert "bridge 'rails' has not answered for" in str(lost[0])


async def test_connecting_without_a_bridge_fails(rails: Rails, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.bridges.finding.TIMEOUT", 0.3)
    with pytest.raises(BackendUnreachable, match="cannot connect to"):
        async with connect_robots(f"{rails.endpoint}-that-is-not-there", "a test"):
            pass
    with pytest.raises(BackendUnreachable, match="no bridge to robots 'road' found at"):
        async with connect_robots(rails.endpoint, "a test", "road"):
            pass
