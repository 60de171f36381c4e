"""Cancelled goals that may continue: runs get a warning, and emergency stops report them."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest

import seoro
from seoro.bridges import wire
from seoro.bridges.serving.event_log import EventLog
from seoro.bridges.serving.node import serving
from seoro.bridges.serving.robot import Handlers
from seoro.bridges.serving.work import Work
from seoro.lab.commands import LabCommands
from seoro.security.network.listener import node_listener

pytestmark = pytest.mark.anyio

SCENARIO = """\
import osc.helpers
import osc.nav2
scenario main:
    tb: differential_drive_robot
    do {}
"""
CALLED_OFF = "tb.nav_to_pose(pose_3d(position_3d(x: 5m))) with:\n        until elapsed(0.1s)"
LEFT = "tb.nav_to_pose(pose_3d(position_3d(x: 5m)), success_on_acceptance: true)"


class Stubborn:
    """A robot that ignores cancellations."""

    info = wire.RobotInfo(name="tb", kinds=("differential_drive_robot", "robot"), frames=())
    health = wire.RobotHealth()

    def __init__(self, work: Work, _events: EventLog) -> None:
        self.work = work
        self.handlers: Handlers = {wire.NAVIGATE_THROUGH_POSES: self._navigate}

    async def stop(self) -> None:
        """Command zero velocity, in vain."""

    async def _navigate(self, request: wire.NavigateThroughPoses) -> wire.Empty:
        async def go() -> str:
            try:
                await anyio.sleep_forever()
            finally:
                self.work.warn(request.id, "it may go on")
                self.work.mark_unsettled("tb")
            return ""

        self.work.start(request.id, go, robot="tb")
        return wire.Empty()


@asynccontextmanager
async def stubborn(endpoint: str) -> AsyncIterator[Stubborn]:
    """Yield a stubborn robot behind a bridge."""
    robots: list[Stubborn] = []

    def make(work: Work, events: EventLog) -> Sequence[Stubborn]:
        robots.append(Stubborn(work, events))
        return robots

    async with serving(node_listener(endpoint, None, "b"), "b", make):
        yield robots[0]


@pytest.mark.parametrize("do", [CALLED_OFF, LEFT], ids=["called off", "left"])
async def test_runs_and_emergency_stops_report_goals_that_may_continue(do: str, tmp_path: Path) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/bridge"
    (tmp_path / "main.osc").write_text(SCENARIO.format(do))
    lab = tmp_path / "lab.yaml"
    lab.write_text(f"bridges:\n  b: {{connect: {endpoint}}}\nrobots:\n  tb: {{in: b}}\n")
    async with stubborn(endpoint) as robot:
        async with seoro.start(seoro.load(tmp_path / "main.osc"), lab=seoro.Lab(lab)) as run:
            verdict = await run.result()
        assert verdict.passed
        warnings = [line.partition("warning: ")[2] for line in verdict.logs]
        assert [each for each in warnings if "not reported" not in each] == ["it may go on"]
        [outcome] = await LabCommands([endpoint]).emergency_stop_all("ana@lab", "smoke")
        assert outcome.error == "stopped tb; goals of tb have not ended, and may continue"
        robot.work.mark_settled("tb")
        [outcome] = await LabCommands([endpoint]).emergency_stop_all("ana@lab", "smoke")
        assert (outcome.error, outcome.done) == ("", "stopped tb")
