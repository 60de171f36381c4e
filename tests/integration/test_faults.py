"""Faults in scenarios, with a simulator."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from seoro.cli.main import main
from tests.integration.conftest import read_trace
from tests.sim_nodes.engines import needs_pictures

pytestmark = pytest.mark.engine("mujoco")

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

CAMERAS = """
import osc.helpers
import osc.faults
import osc.cameras
import osc.driving

scenario main:
    robot: differential_drive_robot
    eye: camera with:
        keep(it.width == 64)
        keep(it.height == 48)
    ghost: camera
    front: camera with:
        keep(it.source == 'turtlebot4/front')
    do serial:
        eye.place(pose_3d(position_3d(x: -1m, y: 0m, z: 0.5m)))
        parallel(overlap: inside):
            robot.drive(0.05mps, 25degps, duration: 12s)
            serial:
                eye.inject_noise(0.1)
                eye.inject_bias(-0.2)
                eye.inject_dead_pixels(0.1)
                eye.inject_dead_area(left: 0.5)
                eye.inject_message_loss(0.5)
                eye.inject_freeze()
                eye.clear_faults()
                eye.inject_delay(100ms)
                eye.inject_power_loss()
                robot.inject_bias('front', brightness_offset: 0.2)
                robot.inject_dead_pixels('front', 0.1)
                robot.inject_dead_area('front', top: 0.5)
                eye.take_snapshot() with:
                    failure_is_success()
                eye.clear_faults()
                ghost.inject_freeze() with:
                    failure_is_success()
                front.inject_noise(0.0) with:
                    failure_is_success()
                robot.inject_dead_sector(10deg, 20deg, 'front') with:
                    failure_is_success()
                eye.hold_faults(duration: 1s)
                eye.inject_bias(0.1)
                parallel(overlap: inside):
                    serial:
                        wait elapsed(100ms)
                        eye.remove()
                    eye.hold_faults()
"""


def run(text: str, folder: Path, node: str) -> list[dict[str, Any]]:
    scenario = folder / "main.osc"
    scenario.write_text(text)
    options = ["--connect", node, "--world", "maze", "--rate", "max", "--seed", "1", "-o", str(folder)]
    main(["exec", str(scenario), *options])
    return read_trace(folder / "trace.jsonl")


def reasons(records: list[dict[str, Any]]) -> list[str]:
    """Return the reasons of allowed failures of actions, in order."""
    return [r["reason"].partition(" failed: ")[2] for r in records if r["kind"] == "attempt.end"]


def logs(records: list[dict[str, Any]]) -> list[str]:
    return [r["message"] for r in records if r["kind"] == "log"]


def test_parameters_of_the_scan_modifier_are_faults_of_the_lidar(tmp_path: Path, mujoco_node: str) -> None:
    records = run(PARAMETERS, tmp_path, mujoco_node)
    assert records[-1]["status"] == "passed", records[-1]
    noise, drop = logs(records)
    assert noise.startswith("gaussian_noise of turtlebot4/lidar takes effect: the errors of 3")
    assert drop.startswith("beam_loss of turtlebot4/lidar takes effect: of ")
    nodes = "(nodes with parameters: `laserscan_modification`, `turtlebot4/laserscan_modification`)"
    assert reasons(records) == [
        f"unknown node `/camera` {nodes}",
        f"unknown node `/second/laserscan_modification` {nodes}",
        "unknown parameter `blur` of the node `laserscan_modification` "
        "(parameters: gaussian_noise_std_deviation, random_drop_percentage)",
        "invalid value of the parameter `random_drop_percentage`: expected a number, found `half`",
        "invalid share 7; expected more than 0, and at most 1",
    ]


def test_measurements_of_faults_are_in_the_trace(tmp_path: Path, mujoco_node: str) -> None:
    records = run(FAULTS, tmp_path, mujoco_node)
    assert records[-1]["status"] == "passed", records[-1]
    reported = [message.partition(" takes effect: ")[0] for message in logs(records)]
    assert reported == [
        "bias of turtlebot4/lidar",
        "gaussian_noise of turtlebot4/odometry",
        "dead_sector of turtlebot4/lidar",
        "dead_beams of turtlebot4/lidar",
        "delay of turtlebot4/lidar",
        "freeze of turtlebot4/lidar",
        "power_loss of turtlebot4/lidar",
    ]
    angle, nose, limit = reasons(records)
    assert angle == "lidar cannot have gaussian_noise of angle; quantities: length"
    assert (
        nose == "unknown device 'nose' of turtlebot4; devices: bumper, front, imu, lidar, motors, odometry, robot"
    )
    assert limit == (
        "no effect of gaussian_noise of turtlebot4/lidar was confirmed: no comparable value of length has arrived"
    )


@pytest.mark.more
def test_camera_faults_are_measured_and_missing_images_are_reported(tmp_path: Path, mujoco_node: str) -> None:
    needs_pictures("mujoco")
    records = run(CAMERAS, tmp_path, mujoco_node)
    assert records[-1]["status"] == "passed", records[-1]
    reported = [message.partition(" takes effect: ")[0] for message in logs(records)]
    kinds = ["gaussian_noise", "bias", "dead_pixels", "dead_area", "message_loss", "freeze", "delay", "power_loss"]
    of_robot = [f"{kind} of turtlebot4/front" for kind in ("bias", "dead_pixels", "dead_area")]
    assert reported == [*(f"{kind} of eye" for kind in kinds), *of_robot, "bias of eye"]
    power, ghost, nothing, sector = reasons(records)
    assert power == "no image from 'eye': the camera has no power"
    assert ghost.startswith("unknown camera 'ghost'")
    assert nothing == "invalid deviations nothing; expected zero or more, and not all zero"
    assert sector == "front cannot have dead_sector: it has no beams"
