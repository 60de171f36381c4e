"""Goals of MoveIt's action `MoveGroup`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

SPHERE: Final = 2  # shape_msgs/msg/SolidPrimitive
PLANNING_TIME: Final = 5.0  # [s]
ATTEMPTS: Final = 5

Fields = dict[str, Any]


def joint_constraints(positions: Mapping[str, float], tolerance: float) -> Fields:
    """Make constraints of a goal: joints at positions [rad, m], within a tolerance."""
    joints = [
        {
            "joint_name": name,
            "position": position,
            "tolerance_above": tolerance,
            "tolerance_below": tolerance,
            "weight": 1.0,
        }
        for name, position in positions.items()
    ]
    return {"joint_constraints": joints}


def pose_constraints(link: str, frame: str, pose: Mapping[str, Any], tolerance: float) -> Fields:
    """Make constraints of a goal: a link at a pose.

    Args:
        link: Name of the link.
        frame: Frame of the pose.
        pose: Members of a `geometry_msgs/Pose`.
        tolerance: Tolerance of the position [m] and of the rotation about each axis [rad].
    """
    header = {"frame_id": frame}  # a stamp of zero selects the latest transform
    ball = {"type": SPHERE, "dimensions": [tolerance]}
    position = {
        "header": header,
        "link_name": link,
        "constraint_region": {
            "primitives": [ball],
            "primitive_poses": [{"position": pose["position"], "orientation": {"w": 1.0}}],
        },
        "weight": 1.0,
    }
    orientation = {
        "header": header,
        "link_name": link,
        "orientation": pose["orientation"],
        **{f"absolute_{axis}_axis_tolerance": tolerance for axis in "xyz"},
        "weight": 1.0,
    }
    return {"position_constraints": [position], "orientation_constraints": [orientation]}


def move_group_goal(group: str, constraints: Fields, scaling: float, *, plan_only: bool, replan: bool) -> Fields:
    """Make a goal.

    Args:
        group: Planning group.
        constraints: Constraints of the goal.
        scaling: Share of the maximum speeds and accelerations.
        plan_only: Whether to plan without moving.
        replan: Whether to plan again if a new obstacle blocks the path.
    """
    return {
        "request": {
            "start_state": {"is_diff": True},  # the present state
            "goal_constraints": [constraints],
            "group_name": group,
            "num_planning_attempts": ATTEMPTS,
            "allowed_planning_time": PLANNING_TIME,
            "max_velocity_scaling_factor": scaling,
            "max_acceleration_scaling_factor": scaling,
        },
        "planning_options": {"plan_only": plan_only, "replan": replan},
    }
