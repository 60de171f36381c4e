"""Goals for servers of other distributions, and the reasons of their errors."""

from __future__ import annotations

import re

import pytest

from seoro.bridges.ros2.clients.editions import adapt, check_fits
from seoro.bridges.ros2.interfaces import InvalidValue, TypeStore
from seoro.robotics import moveit_errors, nav2_errors
from seoro.robotics.goal_results import describe_failure
from tests.tools.ros_definitions import definitions

THROUGH = "nav2_msgs/action/NavigateThroughPoses"
GENUINE_GOALS = "RIHS01_02305a51633b5c04d8979b878a7577cafd422f8a07465c878b17a920af3759e9"  # of Kilted's package
DISTRIBUTIONS = ("humble", "jazzy", "kilted", "lyrical")


def test_poses_become_goals_where_the_distribution_has_them() -> None:
    goal = {"poses": [{"header": {"frame_id": "map"}}, {}]}
    assert adapt(definitions("jazzy"), f"{THROUGH}_Goal", goal) == goal
    kilted = definitions("kilted")
    assert kilted.type_hash("nav_msgs/msg/Goals") == GENUINE_GOALS
    adapted = adapt(kilted, f"{THROUGH}_Goal", goal)
    message = kilted.message(f"{THROUGH}_Goal", adapted)
    assert (message.poses.header.frame_id, len(message.poses.goals)) == ("map", 2)
    found = TypeStore.bundled().matching(f"{THROUGH}_SendGoal", kilted.type_hash(f"{THROUGH}_SendGoal"))
    assert found is not None


def test_members_of_any_distribution_are_valid() -> None:
    types = TypeStore.bundled()
    check_fits(types, "nav2_msgs/action/Spin_Goal", {"disable_collision_checks": True})  # since Kilted
    with pytest.raises(InvalidValue, match="unknown member `angle`"):
        check_fits(types, "nav2_msgs/action/Spin_Goal", {"angle": 1.0})


@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
def test_each_error_code_of_nav2_has_words(distribution: str) -> None:
    types = definitions(distribution)
    actions = [name for name in types.names() if name.startswith("nav2_msgs/action/")]
    checked = 0
    for action in actions:
        for constant in types.structure(f"{action}_Result").constants:
            if int(constant.value) <= 0:  # no error, or an index
                continue
            found = nav2_errors.find_error(action.rpartition("/")[2], int(constant.value))
            assert found is not None, (action, constant)
            assert found[0] == constant.name, (action, constant)
            checked += 1
    assert checked > (10 if distribution == "humble" else 60)


def test_no_error_code_of_nav2_is_invented() -> None:
    defined = {
        int(constant.value)
        for distribution in DISTRIBUTIONS
        for types in [definitions(distribution)]
        for name in types.names()
        if name.startswith("nav2_msgs/action/")
        for constant in types.structure(f"{name}_Result").constants
    }
    assert {code for code in range(1, 10_000) if nav2_errors.find_error("Spin", code)} <= defined


@pytest.mark.parametrize("distribution", ["humble", "jazzy"])
def test_each_error_code_of_moveit_has_words(distribution: str) -> None:
    constants = TypeStore.bundled(distribution).structure("moveit_msgs/msg/MoveItErrorCodes").constants
    assert all(
        moveit_errors.ERRORS[int(each.value)][0] == each.name for each in constants if each.name != "SUCCESS"
    )


@pytest.mark.parametrize(
    ("kind", "result", "reason"),
    [
        ("Spin", {"error_code": 0}, ""),
        (
            "Spin",
            {"error_code": 703, "error_msg": "at x"},
            "obstacle is in the way.*COLLISION_AHEAD, error 703.*at x",
        ),
        ("NavigateToPose", {"error_code": 208}, "no path leads to the goal.*NO_VALID_PATH, error 208"),
        ("NavigateToPose", {"error_code": 4711}, "unknown error code 4711"),
        ("DockRobot", {"success": False, "error_code": 904}, "marker.*FAILED_TO_DETECT_DOCK"),
        ("FollowObject", {"error_code": 904}, "TIMEOUT"),
        ("DockRobot", {"success": False}, "reports no success"),
        ("FollowWaypoints", {"missed_waypoints": [0, 2]}, "^missed waypoints: 1, 3$"),
        ("FollowWaypoints", {"missed_waypoints": [{"index": 1}], "error_code": 601}, "waypoints: 2; the task"),
        ("FollowWaypoints", {"missed_waypoints": [{"waypoint_index": 1}]}, "missed waypoints: 2"),
        ("FollowWaypoints", {}, ""),
    ],
)
def test_results_of_nav2_are_described(kind: str, result: dict[str, object], reason: str) -> None:
    found = describe_failure(f"nav2_msgs/action/{kind}", result)
    assert re.search(reason, found) if reason else found == "", found
