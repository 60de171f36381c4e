"""Robots in graphs of ROS 2 systems."""

from __future__ import annotations

from seoro.bridges.ros2.adoption.finding import FoundRobot, find_robots
from tests.bridges.ros2.adoption.graphs import graph_of

Entities = list[tuple[str, str, str]]

BASE: Entities = [("/driver", "cmd_vel", "/cmd_vel"), ("/driver", "odometry", "/odom"), ("/driver", "tf", "/tf")]


def found(entities: Entities) -> dict[str, FoundRobot]:
    return {robot.namespace: robot for robot in find_robots(graph_of(entities), "bb")}


def names(robot: FoundRobot) -> dict[str, str]:
    return {part: robot.relative(robot.name(part)) for part in robot.parts}


def test_a_base_without_a_namespace_is_found() -> None:
    assert {space: names(robot) for space, robot in found(BASE).items()} == {
        "/": {"cmd_vel": "cmd_vel", "odometry": "odom", "tf": "tf"}
    }


def test_robots_of_namespaces_share_frames_of_the_root() -> None:
    robots = found(
        [
            *((f"{space}/driver", "cmd_vel", f"{space}/cmd_vel") for space in ("/tb1", "/tb2")),
            ("/tb1/driver", "odometry", "/tb1/odom"),
            ("/tb1/driver", "tf", "/tb1/tf"),
            ("/gateway", "tf", "/tf"),
            ("/gateway", "odometry", "/odom"),
        ]
    )
    assert names(robots["/tb1"]) == {"cmd_vel": "cmd_vel", "odometry": "odom", "tf": "tf"}
    assert names(robots["/tb2"]) == {"cmd_vel": "cmd_vel", "tf": "/tf"}
    assert robots.keys() == {"/tb1", "/tb2"}


def test_a_robot_in_the_root_has_nothing_of_others() -> None:
    robots = found([*BASE, ("/tb1/driver", "cmd_vel", "/tb1/cmd_vel"), ("/tb1/driver", "battery", "/tb1/battery")])
    assert "battery" not in robots["/"]
    assert robots["/tb1"].relative("/tb1/battery") == "battery"


def test_controllers_are_below_the_namespace_of_their_robot() -> None:
    robots = found(
        [
            ("/bot/diff_drive", "cmd_vel", "/bot/diff_drive/cmd_vel"),  # a private name
            ("/bot/diff_drive", "odometry", "/bot/diff_drive/odom"),
            ("/manager", "trajectory", "/bot/joint_trajectory_controller/follow_joint_trajectory"),
            ("/bot/broadcaster", "joint_states", "/bot/joint_states"),
        ]
    )
    assert robots.keys() == {"/bot"}
    assert names(robots["/bot"]) == {
        "cmd_vel": "diff_drive/cmd_vel",
        "odometry": "diff_drive/odom",
        "trajectory": "joint_trajectory_controller/follow_joint_trajectory",
        "joint_states": "joint_states",
    }


def test_an_arm_below_a_named_base_is_part_of_it() -> None:
    robots = found(
        [
            ("/bot/driver", "cmd_vel", "/bot/cmd_vel"),
            ("/bot/arm/controller", "trajectory", "/bot/arm/controller/follow_joint_trajectory"),
        ]
    )
    assert robots.keys() == {"/bot"}
    assert robots["/bot"].name("trajectory") == "/bot/arm/controller/follow_joint_trajectory"


def test_usual_names_and_drivers_are_preferred() -> None:
    robots = found(
        [("/smoother", "cmd_vel", "/cmd_vel_nav"), *BASE, ("/filter", "odometry", "/odometry/filtered")]
    )
    assert [each.name for each in robots["/"].parts["cmd_vel"]] == ["/cmd_vel", "/cmd_vel_nav"]
    assert [each.name for each in robots["/"].parts["odometry"]] == ["/odom", "/odometry/filtered"]
    driven = found([("/a", "cmd_vel", "/a_cmd"), ("/z", "cmd_vel", "/z_cmd"), ("/z", "odometry", "/odom")])
    assert driven["/"].name("cmd_vel") == "/z_cmd"


def test_poses_of_other_names_are_no_localisation() -> None:
    robots = found([*BASE, ("/rviz", "pose", "/initialpose"), ("/ekf", "initial_pose", "/set_pose")])
    assert not {"pose", "initial_pose"} & robots["/"].parts.keys()


def test_bridges_and_own_endpoints_do_not_count() -> None:
    assert found([("/tb/seoro_bridge", "cmd_vel", "/tb/cmd_vel")]) == {}
    assert find_robots(graph_of(BASE, "bb"), "bb") == ()
    assert found([("/driver", "odometry", "/odom")]) == {}
