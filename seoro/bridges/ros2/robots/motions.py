"""Motions of arms as goals of MoveIt 2 and of trajectory controllers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.robots.profile import Arm, MoveGroup
from seoro.robotics.moveit_goals import Fields, joint_constraints, move_group_goal, pose_constraints

PEAK = 1.5  # ratio of peak and mean speed on a cubic from rest to rest, as controllers interpolate
MIN_DURATION = 0.1  # [s] of a motion
SETTLING = 2.0  # [s] for joints to come to rest within the tolerance


def joint_goal(group: MoveGroup, positions: Mapping[str, float], motion: wire.ArmMotion) -> Fields:
    """Make a goal of MoveIt: joints at positions [rad]."""
    return _planned(group, joint_constraints(positions, motion.tolerance), motion)


def pose_goal(arm: Arm, group: MoveGroup, request: wire.MoveToPose) -> Fields:
    """Make a goal of MoveIt: the tool at a pose. Straight lines use the planner of Pilz Industrial Motion."""
    frame = arm.base_frame if request.frame == "base_link" else request.frame
    constraints = pose_constraints(arm.tool, frame, geometry.pose_message(request.pose), request.tolerance)
    goal = _planned(group, constraints, request)
    if request.straight:
        goal["request"] |= {"pipeline_id": "pilz_industrial_motion_planner", "planner_id": "LIN"}
    return goal


def _planned(group: MoveGroup, constraints: Fields, motion: wire.ArmMotion) -> Fields:
    return move_group_goal(
        group.group,
        constraints,
        motion.max_velocity_scaling_factor,
        plan_only=motion.plan_only,
        replan=motion.replan,
    )


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
