"""What is said of a robot, by what its node knows."""

from __future__ import annotations

from typing import Any

import pytest

from seoro.bridges.wire.lab import LabState, Lease, RobotState, Stopped, TopicState
from seoro.doctor.findings import Health
from seoro.doctor.robots import tell_robot
from seoro.lab.schema import BeforeFile

SILENT = (TopicState(topic="/scan", seen=0.1), TopicState(topic="/odom", why="nobody publishes it"))


def told(before: BeforeFile | None = None, **how: Any) -> list[tuple[Health, str]]:
    robot = RobotState(name="tb", kinds=("robot",), **how)
    lab = LabState(kind="bridge", version="1", robots=(robot,))
    found = list(tell_robot("tb", lab, robot, before))
    assert all(each.help for each in found if each.health is not Health.OK)
    return [(each.health, each.text) for each in found]


def test_a_robot_that_is_well_is_one_line() -> None:
    [(health, text)] = told(seen=0.1, localised=True, deviation=0.05, battery=0.8, waiting=("a drive",))
    assert health is Health.OK
    assert text == "heard of now, free, 1 wait for it, knows where it is, to 0.05 m, battery at 80%"


@pytest.mark.parametrize(
    ("how", "text"),
    [
        ({"holder": "the scenario drive"}, "held by the scenario drive"),
        ({"lease": Lease(lease="hand-1", purpose="new wheels", until=0.0)}, "(new wheels)"),
    ],
)
def test_who_has_it_is_told(how: dict[str, Any], text: str) -> None:
    [(health, said)] = told(seen=0.1, **how)
    assert health is Health.OK
    assert text in said


@pytest.mark.parametrize(
    ("how", "health", "text"),
    [
        ({}, Health.FAILED, "nothing was ever heard of it"),
        ({"topics": SILENT}, Health.FAILED, "/odom (nobody publishes it)"),
        ({"seen": 60.0}, Health.FAILED, "was last heard of 60 s ago"),
        ({"seen": 0.1, "topics": SILENT}, Health.WARNING, "is not heard on all its topics: /odom (nobody"),
        ({"seen": 0.1, "battery": 0.1}, Health.WARNING, "its battery is at 10%"),
        ({"seen": 0.1, "stopped": Stopped(by="ana")}, Health.FAILED, "does not move: emergency stop by ana at"),
    ],
)
def test_what_is_wrong_is_told(how: dict[str, Any], health: Health, text: str) -> None:
    *_, (found, said) = told(**how)
    assert found is health
    assert text in said


def test_what_a_lab_file_asks_for_before_a_run_is_told() -> None:
    *_, (health, text) = told(BeforeFile(battery=0.3, localised=True), seen=0.1, battery=0.2, localised=False)
    assert health is Health.WARNING
    assert text == "is not ready for runs: its battery is at 20%, below 30%; it does not know where it is"
