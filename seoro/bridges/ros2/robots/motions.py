"""Motions of arms as goals of MoveIt 2 and of controllers of joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.robots.profile import Arm, MoveGroup
from seoro.bridges.serving.work import Aborted

SPHERE = 2  # shape_msgs/msg/SolidPrimitive
SUCCESS = 1  # moveit_msgs/msg/MoveItErrorCodes
WHY = {
    99999: "it failed",
    -1: "no plan was found",
    -2: "the plan is invalid",
    -3: "something came into the way",
    -4: "the controller failed",
    -6: "it took too long",
    -7: "another goal has taken its place",
    -10: "it would begin in a collision",
    -12: "it would end in a collision",
    -15: "the group of joints is unknown",
    -16: "the goal contradicts itself",
    -21: "the frame of the goal is unknown",
    -31: "the pose is out of reach",
}
PLANNING_TIME = 5.0  # [s]
ATTEMPTS = 5
PEAK = 1.5  # of the speed over its mean, on a cubic from rest to rest, as controllers interpolate
SHORTEST = 0.1  # [s] of a motion
SETTLING = 2.0  # [s] that joints may take to come to rest within the tolerance

Fields = dict[str, Any]


def joint_goal(group: MoveGroup, positions: Mapping[str, float], motion: wire.ArmMotion) -> Fields:
    """A goal of MoveIt: joints at positions [rad]."""
    constraints = [
        {
            "joint_name": name,
            "position": position,
            "tolerance_above": motion.tolerance,
            "tolerance_below": motion.tolerance,
            "weight": 1.0,
        }
        for name, position in positions.items()
    ]
    return _planned(group, {"joint_constraints": constraints}, motion)


def pose_goal(arm: Arm, group: MoveGroup, request: wire.MoveToPose) -> Fields:
    """A goal of MoveIt: the tool at a pose; in a straight line by the planner of Pilz Industrial Motion."""
    pose, tolerance = geometry.pose_message(request.pose), request.tolerance
    header = geometry.header(arm.base_frame if request.frame == "base_link" else request.frame, 0.0)
    ball = {"type": SPHERE, "dimensions": [tolerance]}
    place = {
        "header": header,
        "link_name": arm.tool,
        "constraint_region": {
            "primitives": [ball],
            "primitive_poses": [{"position": pose["position"], "orientation": {"w": 1.0}}],
        },
        "weight": 1.0,
    }
    turn = {
        "header": header,
        "link_name": arm.tool,
        "orientation": pose["orientation"],
        **{f"absolute_{axis}_axis_tolerance": tolerance for axis in "xyz"},
        "weight": 1.0,
    }
    goal = _planned(group, {"position_constraints": [place], "orientation_constraints": [turn]}, request)
    if request.straight:
        goal["request"] |= {"pipeline_id": "pilz_industrial_motion_planner", "planner_id": "LIN"}
    return goal


def _planned(group: MoveGroup, constraints: Fields, motion: wire.ArmMotion) -> Fields:
    return {
        "request": {
            "start_state": {"is_diff": True},  # where the arm is
            "goal_constraints": [constraints],
            "group_name": group.group,
            "num_planning_attempts": ATTEMPTS,
            "allowed_planning_time": PLANNING_TIME,
            "max_velocity_scaling_factor": motion.max_velocity_scaling_factor,
            "max_acceleration_scaling_factor": motion.max_velocity_scaling_factor,
        },
        "planning_options": {"plan_only": motion.plan_only, "replan": motion.replan},
    }


def judge_plan(result: Mapping[str, Any]) -> str:
    """What MoveIt says of a goal.

    Raises:
        Aborted: It did not succeed, whatever the status of the goal says.
    """
    code = int(result["error_code"]["val"])
    if code != SUCCESS:
        raise Aborted(f"MoveIt: {WHY.get(code, 'the motion failed')} (error {code})")
    return ""


def trajectory_goal(
    names: Sequence[str],
    points: Sequence[Sequence[float]],
    start: Sequence[float],
    speeds: Sequence[float],
    motion: wire.ArmMotion,
) -> Fields:
    """A goal of a controller: joints from where they are through positions [rad], at rest at each.

    Args:
        names: Of the joints.
        points: Their positions.
        start: Where they are.
        speeds: That they can have [rad/s].
        motion: What part of these they are to have, and how exactly they have to be there.
    """
    time, messages, before = 0.0, [], start
    for point in points:
        longest = max(abs(there - here) / speed for here, there, speed in zip(before, point, speeds, strict=True))
        time += max(SHORTEST, PEAK * longest / motion.max_velocity_scaling_factor)
        rest = [0.0] * len(point)
        messages.append({"positions": list(point), "velocities": rest, "time_from_start": geometry.stamp(time)})
        before = point
    return {
        "trajectory": {"joint_names": list(names), "points": messages},
        "goal_tolerance": [{"name": name, "position": motion.tolerance} for name in names],
        "goal_time_tolerance": geometry.stamp(SETTLING),
    }


def judge_trajectory(result: Mapping[str, Any]) -> str:
    """What a controller of joints says of a goal.

    Raises:
        Aborted: It did not succeed, whatever the status of the goal says.
    """
    if code := int(result.get("error_code", 0)):
        raise Aborted(f"the controller: {result.get('error_string') or 'the motion failed'} (error {code})")
    return ""
