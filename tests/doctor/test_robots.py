"""Findings about a robot, from the state of its node."""

from __future__ import annotations

from typing import Any

import pytest

from seoro.bridges.wire.lab import (
    ActiveStop,
    LabState,
    Lease,
    RobotCheck,
    RobotProblem,
    RobotState,
    TopicState,
)
from seoro.doctor.findings import Health
from seoro.doctor.nodes import robot_findings
from seoro.lab.schema import BeforeFile

SILENT = (TopicState(topic="/scan", seen=0.1), TopicState(topic="/odom", why="no publisher"))


def reported(
    before: BeforeFile | None = None, check: RobotCheck | None = None, **how: Any
) -> list[tuple[Health, str]]:
    robot = RobotState(name="tb", kinds=("robot",), **how)
    lab = LabState(kind="bridge", version="1", robots=(robot,))
    found = list(robot_findings("tb", lab, robot, before, check))
    assert all(each.help for each in found if each.health is not Health.OK)
    return [(each.health, each.text) for each in found]


def test_a_healthy_robot_has_one_line() -> None:
    [(health, text)] = reported(seen=0.1, localised=True, deviation=0.05, battery=0.8, waiting=("a drive",))
    assert health is Health.OK
    assert text == "seen now, free, 1 waiting, localised within 0.05 m, battery at 80%"


@pytest.mark.parametrize(
    ("how", "text"),
    [
        ({"holder": "the scenario drive"}, "held by the scenario drive"),
        ({"lease": Lease(lease="hand-1", purpose="new wheels", until=0.0)}, "(new wheels)"),
    ],
)
def test_the_holder_of_a_robot_is_reported(how: dict[str, Any], text: str) -> None:
    [(health, message)] = reported(seen=0.1, **how)
    assert health is Health.OK
    assert text in message


@pytest.mark.parametrize(
    ("how", "health", "text"),
    [
        ({}, Health.FAILED, "no messages received"),
        ({"topics": SILENT}, Health.FAILED, "/odom (no publisher)"),
        ({"seen": 60.0}, Health.FAILED, "last message 60 s ago"),
        ({"seen": 0.1, "topics": SILENT}, Health.WARNING, "topics without messages: /odom (no publisher"),
        ({"seen": 0.1, "battery": 0.1}, Health.WARNING, "battery at 10%"),
        ({"seen": 0.1, "stopped": ActiveStop(by="ana")}, Health.FAILED, "emergency stop by ana at"),
    ],
)
def test_problems_of_a_robot_are_reported(how: dict[str, Any], health: Health, text: str) -> None:
    *_, (found, message) = reported(**how)
    assert found is health
    assert text in message


def test_problems_found_by_the_bridge_replace_silent_topics() -> None:
    problems = (
        RobotProblem(text="no publisher of /odom", help="start it"),
        RobotProblem(text="no server of /navigate_to_pose", help="start it", is_fatal=False),
    )
    found = reported(check=RobotCheck(problems=problems), seen=0.1, topics=SILENT)
    assert found[1:] == [
        (Health.FAILED, "no publisher of /odom"),
        (Health.WARNING, "no server of /navigate_to_pose"),
    ]
    [(health, _)] = reported(check=RobotCheck(), seen=0.1, topics=SILENT)
    assert health is Health.OK


def test_unmet_conditions_of_the_lab_file_are_reported() -> None:
    *_, (health, text) = reported(BeforeFile(battery=0.3, localised=True), seen=0.1, battery=0.2, localised=False)
    assert health is Health.WARNING
    assert text == "not ready for runs: its battery is at 20%, below 30%; it is not localised"
