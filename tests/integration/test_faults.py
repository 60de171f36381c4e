"""Faults in scenarios, with a simulator."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from seoro.cli.main import main
from tests.integration.conftest import read_trace

PARAMETERS = """
import osc.helpers
import osc.ros

scenario main:
    robot: differential_drive_robot
    do serial:
        set_node_parameter('laserscan_modification', 'gaussian_noise_std_deviation', '0.3')
        set_node_parameter('/turtlebot4/laserscan_modification', 'random_drop_percentage', '0.4')
        set_node_parameter('/laserscan_modification', 'gaussian_noise_std_deviation', '0.0')
        set_node_parameter('/camera', 'blur', '0.3') with:
            failure_is_success()
        set_node_parameter('/second/laserscan_modification', 'random_drop_percentage', '0.1') with:
            failure_is_success()
        set_node_parameter('laserscan_modification', 'blur', '0.3') with:
            failure_is_success()
        set_node_parameter('laserscan_modification', 'random_drop_percentage', 'half') with:
            failure_is_success()
        set_node_parameter('laserscan_modification', 'random_drop_percentage', '7') with:
            failure_is_success()
"""

FAULTS = """
import osc.helpers
import osc.faults
import osc.ros

scenario main:
    robot: differential_drive_robot
    do serial:
        robot.inject_bias('lidar', length_offset: 20cm)
        robot.inject_noise('odometry', length_deviation: 1cm, angle_deviation: 2deg)
        robot.inject_dead_sector(-20deg, 20deg)
        robot.inject_dead_beams([0, 1, 2])
        robot.inject_delay('lidar', 200ms)
        robot.inject_freeze('lidar')
        robot.hold_faults('lidar', duration: 1s)
        robot.inject_power_loss('lidar')
        robot.clear_faults()
        robot.inject_noise('lidar', angle_deviation: 2deg) with:
            failure_is_success()
        robot.inject_freeze('nose') with:
            failure_is_success()
        robot.inject_noise('lidar', length_deviation: 1cm, confirm_within: 50ms) with:
            failure_is_success()
"""


def run(text: str, folder: Path) -> list[dict[str, Any]]:
    pytest.importorskip("mujoco", reason="the engine mujoco is not installed")
    scenario = folder / "main.osc"
    scenario.write_text(text)
    main(["exec", str(scenario), "--sim", "mujoco", "--rate", "max", "--seed", "1", "-o", str(folder)])
    return read_trace(folder / "trace.jsonl")


def reasons(records: list[dict[str, Any]]) -> list[str]:
    """Why actions failed whose failure is allowed, in order."""
    return [r["reason"].partition(" failed: ")[2] for r in records if r["kind"] == "attempt.end"]


def logs(records: list[dict[str, Any]]) -> list[str]:
    return [r["message"] for r in records if r["kind"] == "log"]


def test_parameters_of_the_node_that_spoils_scans_are_faults_of_the_lidar(tmp_path: Path) -> None:
    records = run(PARAMETERS, tmp_path)
    assert records[-1]["status"] == "passed", records[-1]
    noise, drop = logs(records)
    assert noise.startswith("gaussian_noise of turtlebot4/lidar takes effect: the errors of 3")
    assert drop.startswith("beam_loss of turtlebot4/lidar takes effect: of ")
    nodes = "of the nodes with parameters there are `laserscan_modification`, `turtlebot4/laserscan_modification`"
    assert reasons(records) == [
        f"there is no node `/camera` here: {nodes}",
        f"there is no node `/second/laserscan_modification` here: {nodes}",
        "the node `laserscan_modification` has no parameter `blur` here: "
        "it has gaussian_noise_std_deviation, random_drop_percentage",
        "the parameter `random_drop_percentage` is a number, not `half`",
        "the share is 7: it has to be above 0, and 1 at most",
    ]


def test_faults_are_measured_and_what_was_measured_stands_in_the_trace(tmp_path: Path) -> None:
    records = run(FAULTS, tmp_path)
    assert records[-1]["status"] == "passed", records[-1]
    told = [message.partition(" takes effect: ")[0] for message in logs(records)]
    assert told == [
        "bias of turtlebot4/lidar",
        "gaussian_noise of turtlebot4/odometry",
        "dead_sector of turtlebot4/lidar",
        "dead_beams of turtlebot4/lidar",
        "delay of turtlebot4/lidar",
        "freeze of turtlebot4/lidar",
        "power_loss of turtlebot4/lidar",
    ]
    angle, nose, limit = reasons(records)
    assert angle == "lidar cannot have gaussian_noise of angle: it measures length"
    assert nose == "turtlebot4 has no device 'nose': it has bumper, imu, lidar, motors, odometry, robot"
    assert limit == (
        "gaussian_noise of turtlebot4/lidar was not found to take effect: "
        "no value of length to compare has arrived"
    )
