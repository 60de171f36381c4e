from __future__ import annotations

import math
from importlib import resources
from typing import Any

import pytest

from seoro.bridges.ros2.urdf import Links, read_links

TURTLEBOT, ARM = (
    read_links(resources.files("sim_nodes.robots").joinpath(f"{name}.urdf").read_text())
    for name in ("turtlebot4", "ur10e")
)


def named(transforms: list[dict[str, Any]]) -> dict[str, Any]:
    return {each["child_frame_id"]: each["transform"] for each in transforms}


def test_fixed_links_have_the_poses_of_the_urdf() -> None:
    fixed = named(TURTLEBOT.fixed())
    assert set(fixed) == {"front_caster", "rplidar_link"}
    lidar = fixed["rplidar_link"]
    assert lidar["translation"] == {"x": -0.04, "y": 0.0, "z": 0.193}
    assert lidar["rotation"]["z"] == pytest.approx(math.sqrt(0.5))


def test_links_move_with_their_joints() -> None:
    [left] = TURTLEBOT.moving({"left_wheel_joint": math.pi / 2}, 3.0)
    assert left["header"] == {"stamp": {"sec": 3, "nanosec": 0}, "frame_id": "base_link"}
    assert left["transform"]["translation"]["y"] == pytest.approx(0.1165)
    turn = left["transform"]["rotation"]
    assert (turn["x"], turn["y"], turn["z"], turn["w"]) == pytest.approx((-0.5, 0.5, 0.5, 0.5))


def test_fingers_move_along_prismatic_joints() -> None:
    names = [joint.name for joint in ARM.joints if joint.kind == "prismatic"]
    before, after = (
        {name: each["translation"] for name, each in named(ARM.moving(dict.fromkeys(names, at), 0.0)).items()}
        for at in (0.0, 0.02)
    )
    moved = [math.dist(before[name].values(), after[name].values()) for name in before]
    assert moved == pytest.approx([0.02, 0.02])


def test_a_robot_of_one_link_has_no_transforms() -> None:
    assert read_links("<robot name='r'><link name='l'/></robot>") == Links((), "r")


def test_limits_and_mimicked_joints_are_read() -> None:
    joints = {joint.name: joint for joint in ARM.joints}
    assert joints["elbow_joint"].limits == pytest.approx((-math.pi, math.pi), abs=1e-3)
    assert all(joint.limits is None for joint in TURTLEBOT.joints if joint.kind == "continuous")
    text = (
        "<robot name='r'><joint name='j' type='prismatic'><mimic joint='k'/><limit lower='-1'/></joint>"
        "<transmission><joint name='j'/></transmission></robot>"
    )
    [joint] = read_links(text).joints
    assert (joint.mimics, joint.limits, joint.speed) == ("k", (-1.0, 0.0), math.inf)


@pytest.mark.parametrize("text", ["", "<robot>", "<robot><joint><limit velocity='fast'/></joint></robot>"])
def test_invalid_urdf_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"invalid URDF|could not convert"):
        read_links(text)
