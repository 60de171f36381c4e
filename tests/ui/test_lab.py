"""State of a lab and emergency stop, with real nodes and executors."""

from __future__ import annotations

import signal
import time
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import anyio
import pytest

from seoro.client.lab import LabControl
from seoro.concurrency.background import background
from seoro.lab.reading import read_lab
from seoro.lab.recorded import RecordedRobot
from seoro.lab.status import listed_robots
from seoro.ui.lab_stop import ANSWER_WITHIN, EmergencyStop
from seoro.ui.lab_watch import LabWatch
from seoro.ui.own_runs import OwnRuns
from tests.bridges.robot.conftest import Rails
from tests.executors import executor
from tests.lab.nodes import Hall, hall_at

pytestmark = pytest.mark.anyio

DEADLINE = 60.0  # [s]


@pytest.fixture(scope="module")
def hall(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Hall]:
    with hall_at(tmp_path_factory.mktemp("hall")) as running:
        yield running


@asynccontextmanager
async def following(watch: LabWatch) -> AsyncIterator[Callable[[Callable[[Mapping[str, Any]], object]], Any]]:
    """Follow a lab while the block lasts; yields a function that waits for a snapshot with a property."""
    async with background() as tasks:
        tasks.start_soon(watch.serve)
        async with watch.followed():
            snapshots = watch.snapshots()

            async def until(has: Callable[[Mapping[str, Any]], object]) -> Mapping[str, Any]:
                with anyio.fail_after(DEADLINE):
                    async for found in snapshots:
                        if has(found):
                            return found
                raise AssertionError("snapshots have no end")

            yield until


def robots_of(snapshot: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    return {robot["name"]: robot for member in snapshot["members"] for robot in member["robots"]}


async def test_a_snapshot_has_real_and_simulated_robots_with_their_leases(hall: Hall, rails: Rails) -> None:
    endpoints = (hall.endpoint, rails.endpoint)
    async with following(LabWatch(lambda: endpoints)) as until:
        first = await until(lambda found: True)
        assert {name: robot["real"] for name, robot in robots_of(first).items()} == {
            "turtlebot4": False,
            "second": False,
            "line": True,
        }
        assert [member["kind"] for member in first["members"]] == ["mujoco", "bridge"]
        assert first["stopped"] is None
        control = LabControl(endpoints)
        lease = await control.lease("second", duration=60.0, purpose="new wheels")
        leased = await until(lambda found: robots_of(found)["second"]["state"] == "leased")
        assert robots_of(leased)["second"]["lease"] == lease.name
        assert robots_of(leased)["second"]["until"] == pytest.approx(lease.until, abs=5.0)
        assert robots_of(leased)["second"]["holder"].startswith("new wheels")
        await control.release("second")
        await until(lambda found: robots_of(found)["second"]["state"] == "free")


async def test_robots_of_a_lab_file_come_first_by_its_names(hall: Hall, tmp_path: Path) -> None:
    file = tmp_path / "lab.yaml"
    file.write_text(
        f"simulators:\n  hall: {{connect: '{hall.endpoint}'}}\n"
        "robots:\n  tb2: {in: hall, as: second, type: turtlebot4}\n  tb9: {in: hall, as: ninth}\n",
        encoding="utf-8",
    )
    lab = read_lab(file)
    async with following(LabWatch(lambda: lab.endpoints, listed=listed_robots(lab))) as until:
        found = robots_of(await until(lambda found: True))
    assert [(name, robot["state"]) for name, robot in found.items()] == [
        ("tb2", "free"),
        ("tb9", "not found"),
        ("turtlebot4", "free"),
    ]
    assert found["tb9"]["detail"] == "the node has no robot 'ninth'"


async def test_recorded_robots_of_a_lab_file_are_listed(hall: Hall) -> None:
    recorded = [
        RecordedRobot("tb", "cart", "field/drive", "5.0 s, 3 topics"),
        RecordedRobot("x", "", "field/drive", problem="lost"),
    ]
    async with following(LabWatch(lambda: [hall.endpoint], recorded=recorded)) as until:
        found = await until(lambda found: True)
    bag = found["members"][-1]
    assert (bag["kind"], bag["endpoint"]) == ("bag", "field/drive")
    assert [(each["name"], each["state"], each["detail"]) for each in bag["robots"]] == [
        ("tb", "recorded", "5.0 s, 3 topics"),
        ("x", "unreadable", "lost"),
    ]


async def test_unreachable_endpoints_are_problems_unless_they_are_optional(hall: Hall, tmp_path: Path) -> None:
    nobody, other = f"unixsock-stream/{tmp_path}/nobody", f"unixsock-stream/{tmp_path}/other"
    async with following(LabWatch(lambda: [hall.endpoint, nobody], optional=[other])) as until:
        found = await until(lambda found: True)
    assert [(member["endpoint"], bool(member["problem"])) for member in found["members"]] == [
        (hall.endpoint, False),
        (nobody, True),
    ]


async def test_the_emergency_stop_answers_in_time_though_half_of_the_lab_does_not(
    hall: Hall, start_rails: Callable[..., Rails], tmp_path: Path
) -> None:
    rails = start_rails("--listen", f"unixsock-stream/{tmp_path}/rails")
    with executor(tmp_path) as running:
        endpoints = (hall.endpoint, rails.endpoint, running.endpoint)
        watch, control = LabWatch(lambda: endpoints), LabControl(endpoints)
        async with following(watch) as until, background() as tasks:
            await until(lambda found: True)
            rails.process.send_signal(signal.SIGSTOP)
            try:
                began = time.monotonic()
                outcomes = await EmergencyStop(control, watch, tasks, OwnRuns()).stop_all("smoke")
                took = time.monotonic() - began
                found = await until(lambda found: found["stopped"])
            finally:
                rails.process.send_signal(signal.SIGCONT)
            assert took < ANSWER_WITHIN + 1.0
            errors = {outcome["name"]: outcome["error"] for outcome in outcomes}
            assert errors["the node 'hall'"] == errors["the executor 'lab-a'"] == ""
            assert "no answer within 2 s" in errors["the node 'rails'"]
            assert found["stopped"]["reason"].endswith("smoke") or "(smoke)" in found["stopped"]["reason"]
            await until(lambda found: found["stopped"] and found["stopped"]["count"] == 3)
            await LabControl([hall.endpoint]).release_all("the test is over")


async def test_an_emergency_stop_that_reaches_nothing_is_an_error(tmp_path: Path) -> None:
    endpoints = [f"unixsock-stream/{tmp_path}/nobody"]

    own = OwnRuns()
    stopped: list[str] = []
    async with background() as tasks:
        optional = LabWatch(tuple, optional=endpoints)
        stop = EmergencyStop(LabControl(endpoints), optional, tasks, own)
        (outcome,) = await stop.stop_all("")
        assert outcome["error"] == "nothing was reached: no node, no executor and no run"
        with own.active("the run 12", lambda: stopped.append("12")):
            assert await stop.stop_all("") == [{"name": "the run 12", "error": "", "done": "stopped"}]
        assert stopped == ["12"]
