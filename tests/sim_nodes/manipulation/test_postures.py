"""Postures: named positions of joints in declarations of robots."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome, RobotName
from seoro.bridges.wire.refusal import RequestRefused
from seoro.files.yaml_lines import FileError
from sim_nodes.robots.derive.complete import declared_form
from sim_nodes.robots.reading import read_robot
from tests.sim_nodes import robots_of_makers as makers
from tests.sim_nodes.client import Client
from tests.sim_nodes.manipulation.test_bodies_of_joints import ENGINES, four_legs
from tests.sim_nodes.test_references import declare, load_installed, three_joints, world

LEGS = "drive: joints\npostures:\n  crouch: {'*_hip': 0.4}\n  lean: {'front_*': -0.3, front_right_hip: -0.2}"


def take(client: Client, posture: str, speed: float = 0.3) -> wire.Occurrence:
    """Take a posture; return the result."""
    request = wire.TakePosture(
        id="take", robot="mine", posture=posture, max_velocity_scaling_factor=speed, tolerance=0.05
    )
    client.ask(wire.TAKE_POSTURE, request)
    return client.run_until("take")[0]


def positions(client: Client) -> tuple[float, ...]:
    return client.ask(wire.GET_JOINT_STATES, RobotName(robot="mine")).positions


@pytest.mark.parametrize("engine", ENGINES)
def test_a_robot_takes_the_postures_of_its_declaration(tmp_path: Path, engine: str) -> None:
    declare(tmp_path, four_legs(), LEGS)
    client = Client(world(tmp_path, "mine.yaml"), engine=engine)
    assert take(client, "crouch").outcome is Outcome.SUCCEEDED
    assert positions(client) == pytest.approx((0.4, 0.4, 0.4, 0.4), abs=0.05)
    assert take(client, "lean").outcome is Outcome.SUCCEEDED
    assert positions(client) == pytest.approx((-0.3, -0.2, 0.4, 0.4), abs=0.05)
    described = client.ask(wire.GET_ROBOT_DESCRIPTION, RobotName(robot="mine")).arm
    assert described is not None
    assert described.postures == ("crouch", "lean")
    with pytest.raises(RequestRefused, match="unknown posture 'sit' of mine; postures: crouch, lean"):
        take(client, "sit")


def test_a_hand_closes_and_opens(tmp_path: Path) -> None:
    load_installed("allegro_hand")
    client = Client(world(tmp_path, "allegro_hand, pose: {z: 0.5}"))
    assert take(client, "closed", 0.05).outcome is Outcome.SUCCEEDED
    assert positions(client)[:4] == pytest.approx((0.0, 1.2, 1.2, 1.2), abs=0.05)
    assert take(client, "open", 0.05).outcome is Outcome.SUCCEEDED
    assert positions(client)[:4] == pytest.approx((0.0, 0.0, 0.0, 0.0), abs=0.05)


@pytest.mark.parametrize(
    ("postures", "words"),
    [
        (
            "{sit: {knee: 1.0}}",
            "`postures.sit` names the unknown joint 'knee'; expected names or patterns of front_",
        ),
        (
            "{sit: {'*_hip': 2.0}}",
            "invalid `postures.sit` 2.000 rad of front_left_hip; expected -1.000 to 1.000 rad",
        ),
        ("{sit: 1.0}", "invalid posture 'sit'; expected positions by joint or pattern, such as {'*_knee': 1.2}"),
        ("{sit: {}}", "invalid posture 'sit'"),
        ("[sit]", "postures"),
        ("{sit: {'*_hip': low}}", "valid number"),
    ],
)
def test_invalid_postures_are_refused(tmp_path: Path, postures: str, words: str) -> None:
    path = declare(tmp_path, four_legs(), f"drive: joints\npostures: {postures}")
    with pytest.raises(FileError) as refused:
        read_robot(path)
    assert words in str(refused.value)


def test_postures_of_a_robot_without_joints_are_refused(tmp_path: Path) -> None:
    makers.write_robot(tmp_path, makers.two_wheels(), "differential", "postures: {sit: {knee: 1.0}}\n")
    with pytest.raises(FileError, match="`postures` of a robot without joints to move"):
        read_robot(tmp_path / "robot.yaml")


def test_a_mounted_arm_keeps_its_postures_with_its_prefix(tmp_path: Path) -> None:
    declare(tmp_path, three_joints(), "drive: arm\npostures: {up: {'j[12]': 0.0}, down: {j2: 1.0}}")
    more = "mounted: {robot: mine.yaml, link: chassis, z: 0.05}\npostures: {down: {arm_j2: 1.5}}\n"
    makers.write_robot(tmp_path, makers.two_wheels(), "differential", more)
    content = declared_form(read_robot(tmp_path / "robot.yaml"))
    assert content["postures"] == {"up": {"arm_j[12]": 0.0}, "down": {"arm_j2": 1.5}}
