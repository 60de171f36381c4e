"""Error codes of MoveIt as reasons; names and numbers are those of `moveit_msgs/msg/MoveItErrorCodes`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

SUCCESS: Final = 1
ERRORS: Final[Mapping[int, tuple[str, str]]] = {
    0: ("UNDEFINED", "no result; look at the log of move_group"),
    99999: ("FAILURE", "failure; look at the log of move_group"),
    -1: ("PLANNING_FAILED", "no plan found; look at obstacles of the planning scene, and at the allowed time"),
    -2: ("INVALID_MOTION_PLAN", "invalid plan; look at the planner and its request adapters"),
    -3: ("MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE", "the environment changed during the motion"),
    -4: ("CONTROL_FAILED", "the controller failed; look at its state, and at limits and contacts of the arm"),
    -5: ("UNABLE_TO_AQUIRE_SENSOR_DATA", "no data of the sensors"),
    -6: ("TIMED_OUT", "timeout; allow more time, or look at what slows the arm"),
    -7: ("PREEMPTED", "preempted by another goal"),
    -10: ("START_STATE_IN_COLLISION", "collision at the start; look at the planning scene around the arm"),
    -11: ("START_STATE_VIOLATES_PATH_CONSTRAINTS", "the start violates constraints of the path"),
    -12: ("GOAL_IN_COLLISION", "collision at the goal; look at the planning scene there"),
    -13: ("GOAL_VIOLATES_PATH_CONSTRAINTS", "the goal violates constraints of the path"),
    -14: ("GOAL_CONSTRAINTS_VIOLATED", "the arm ended beyond the tolerance of the goal"),
    -15: ("INVALID_GROUP_NAME", "unknown group of joints; look at the groups of the SRDF"),
    -16: ("INVALID_GOAL_CONSTRAINTS", "contradictory goal constraints"),
    -17: ("INVALID_ROBOT_STATE", "invalid state of the robot; look at /joint_states"),
    -18: ("INVALID_LINK_NAME", "unknown link; look at the links of the URDF"),
    -19: ("INVALID_OBJECT_NAME", "unknown object of the planning scene"),
    -21: ("FRAME_TRANSFORM_FAILURE", "unknown frame of the goal; look at /tf"),
    -22: ("COLLISION_CHECKING_UNAVAILABLE", "collisions cannot be checked"),
    -23: ("ROBOT_STATE_STALE", "the state of the robot is too old; look at /joint_states and at the clocks"),
    -24: ("SENSOR_INFO_STALE", "the data of the sensors is too old"),
    -25: ("COMMUNICATION_FAILURE", "a node of MoveIt does not answer"),
    -26: ("START_STATE_INVALID", "invalid start; look at the limits of the joints"),
    -27: ("GOAL_STATE_INVALID", "invalid goal; look at the limits of the joints"),
    -28: ("UNRECOGNIZED_GOAL_TYPE", "unknown kind of goal"),
    -29: ("CRASH", "the planner crashed"),
    -30: ("ABORT", "the motion was aborted"),
    -31: ("NO_IK_SOLUTION", "the pose is out of reach"),
}
"""Name of the constant and its words, by code."""


def describe_failure(result: Mapping[str, Any]) -> str:
    """Return why a result or response of MoveIt is a failure; empty for a success.

    Args:
        result: Its members, with `error_code`.
    """
    error = result["error_code"]
    code = int(error["val"])
    if code == SUCCESS:
        return ""
    name, words = ERRORS.get(code, ("", "the motion failed"))
    text = str(error.get("message", ""))
    return f"MoveIt: {words} ({f'{name}, ' * bool(name)}error {code}){f': {text}' * bool(text)}"
