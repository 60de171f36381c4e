"""Failures in the results of well-known ROS actions, in plain words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from seoro.robotics import moveit_errors, nav2_errors

_MOVEIT = ("MoveGroup", "ExecuteTrajectory", "MoveGroupSequence")


def describe_failure(type_name: str, result: Mapping[str, Any]) -> str:
    """Return why a result of an action is a failure; empty for successes and for unknown types.

    Args:
        type_name: Full name of the type of the action.
        result: Members of the result.
    """
    package, _, name = type_name.partition("/action/")
    if package == "nav2_msgs":
        return nav2_errors.describe_failure(name, result)
    if package == "moveit_msgs" and name in _MOVEIT:
        members = result.get("response", result)  # `MoveGroupSequence` nests its result
        return moveit_errors.describe_failure(members)
    if package == "control_msgs" and (code := int(result.get("error_code", 0))):
        return f"the controller: {result.get('error_string') or 'the motion failed'} (error {code})"
    return ""
