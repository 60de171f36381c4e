"""Motions of arms as goals of MoveIt 2 and of trajectory controllers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.robots.profile import Arm, MoveGroup

SPHERE = 2  # shape_msgs/msg/SolidPrimitive
PLANNING_TIME = 5.0  # [s]
ATTEMPTS = 5
PEAK = 1.5  # ratio of peak and mean speed on a cubic from rest to rest, as controllers interpolate
MIN_DURATION = 0.1  # [s] of a motion
SETTLING = 2.0  # [s] for joints to come to rest within the tolerance

Fields = dict[str, Any]


def joint_goal(group: MoveGroup, positions: Mapping[str, float], motion: wire.ArmMotion) -> Fields:
    """Make a goal of MoveIt: joints at positions [rad]."""
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
    """Make a goal of MoveIt: the tool at a pose. Straight lines use the planner of Pilz Industrial Motion."""
    pose, tolerance = geometry.pose_message(request.pose), request.tolerance
    header = geometry.header(arm.base_frame if request.frame == "base_link" else request.frame, 0.0)
    ball = {"type": SPHERE, "dimensions": [tolerance]}
    position = {
        "header": header,
        "link_name": arm.tool,
        "constraint_region": {
            "primitives": [ball],
            "primitive_poses": [{"position": pose["position"], "orientation": {"w": 1.0}}],
        },
        "weight": 1.0,
    }
    orientation = {
        "header": header,
        "link_name": arm.tool,
        "orientation": pose["orientation"],
        **{f"absolute_{axis}_axis_tolerance": tolerance for axis in "xyz"},
        "weight": 1.0,
    }
    constraints = {"position_constraints": [position], "orientation_constraints": [orientation]}
    goal = _planned(group, constraints, request)
    if request.straight:
        goal["request"] |= {"pipeline_id": "pilz_industrial_motion_planner", "planner_id": "LIN"}
    return goal


def _planned(group: MoveGroup, constraints: Fields, motion: wire.ArmMotion) -> Fields:
    return {
        "request": {
            "start_state": {"is_diff": True},  # the present state
            "goal_constraints": [constraints],
            "group_name": group.group,
            "num_planning_attempts": ATTEMPTS,
            "allowed_planning_time": PLANNING_TIME,
            "max_velocity_scaling_factor": motion.max_velocity_scaling_factor,
            "max_acceleration_scaling_factor": motion.max_velocity_scaling_factor,
        },
        "planning_options": {"plan_only": motion.plan_only, "replan": motion.replan},
    }


def trajectory_goal(
    names: Sequence[str],
    points: Sequence[Sequence[float]],
    start: Sequence[float],
    speeds: Sequence[float],
    motion: wire.ArmMotion,
) -> Fields:
    """Make a goal of a trajectory controller: joints through positions [rad], at rest at each.

    Args:
        names: Names of the joints.
        points: Positions of the joints.
        start: Present positions of the joints.
        speeds: Maximum speeds of the joints [rad/s].
        motion: Scaling of the speeds, and the tolerance.
    """
    time, messages, before = 0.0, [], start
    for point in points:
        longest = max(abs(new - old) / speed for old, new, speed in zip(before, point, speeds, strict=True))
        time += max(MIN_DURATION, PEAK * longest / motion.max_velocity_scaling_factor)
        rest = [0.0] * len(point)
        messages.append({"positions": list(point), "velocities": rest, "time_from_start": geometry.stamp(time)})
        before = point
    return {
        "trajectory": {"joint_names": list(names), "points": messages},
        "goal_tolerance": [{"name": name, "position": motion.tolerance} for name in names],
        "goal_time_tolerance": geometry.stamp(SETTLING),
    }
