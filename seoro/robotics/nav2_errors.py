"""Error codes of Nav2's actions as reasons.

Results have an error code since Jazzy; those of Humble have none. Each server has a range of codes, and
`NavigateToPose` reports the code of the server that failed. Numbers and names are those of the definitions of
`nav2_msgs`; tests compare them with all bundled distributions.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

_GOALS: Final = {
    "GOAL_REJECTED": "the server rejected the goal; look at its log and at the state of its node",
    "SEND_GOAL_FAILURE": "the goal could not be sent to the server; check that its node is active",
}
_COMMON: Final = {
    "UNKNOWN": "unknown reason; look at the log of the server",
    "TIMEOUT": "the time limit was exceeded",
    "TF_ERROR": "a transform is missing or too old; look at /tf from `map` to the robot, and at the clocks",
}
_BEHAVIOR: Final = {
    **_COMMON,
    "TIMEOUT": "the time limit of the motion was exceeded; allow more time, or look at what holds the robot",
    "COLLISION_AHEAD": "an obstacle is in the way; look at the local costmap",
    "INVALID_INPUT": "invalid goal; expected a motion along x with a speed in its direction",
}
_PLAN: Final = {
    **_COMMON,
    "INVALID_PLANNER": "unknown planner; look at `planner_plugins` of the planner server",
    "START_OUTSIDE_MAP": "the robot is outside of the map; look at the localisation",
    "GOAL_OUTSIDE_MAP": "the goal is outside of the map; look at its coordinates and frame",
    "START_OCCUPIED": "the robot is in an obstacle of the global costmap; look at the localisation",
    "GOAL_OCCUPIED": "the goal is in an obstacle of the global costmap; choose another one, or clear it",
    "TIMEOUT": "the planner exceeded its time limit",
    "NO_VALID_PATH": "no path leads to the goal; look for closed doors and unknown areas in the global costmap",
    "NO_VIAPOINTS_GIVEN": "no poses given; expected at least one",
}
_CONTROL: Final = {
    **_COMMON,
    "INVALID_CONTROLLER": "unknown controller; look at `controller_plugins` of the controller server",
    "INVALID_PATH": "the path is empty or invalid",
    "PATIENCE_EXCEEDED": "the controller found no valid velocity for too long; look at the local costmap",
    "FAILED_TO_MAKE_PROGRESS": "the robot does not move; look for slipping wheels, contacts and stops",
    "NO_VALID_CONTROL": "the controller found no valid velocity; look at obstacles near the robot",
    "CONTROLLER_TIMED_OUT": "the controller missed its rate; look at the load of the computer",
}
_ROUTE: Final = {
    **_COMMON,
    "NO_VALID_GRAPH": "the route server has no valid graph; look at `graph_filepath`",
    "INDETERMINANT_NODES_ON_GRAPH": "start or goal is unclear on the graph; give ids of its nodes",
    "NO_VALID_ROUTE": "no route leads to the goal; look for closed edges of the graph",
    "OPERATION_FAILED": "an operation along the route failed; look at the log of the route server",
    "INVALID_EDGE_SCORER_USE": "an edge scorer cannot be used for this goal; look at `edge_cost_functions`",
}
_SMOOTH: Final = {
    **_COMMON,
    "INVALID_SMOOTHER": "unknown smoother; look at `smoother_plugins` of the smoother server",
    "SMOOTHED_PATH_IN_COLLISION": "the smoothed path touches an obstacle",
    "FAILED_TO_SMOOTH_PATH": "the smoother found no path",
    "INVALID_PATH": "the path is empty or invalid",
}
_WAYPOINTS: Final = {
    **_COMMON,
    "TASK_EXECUTOR_FAILED": "the task at a waypoint failed; look at the plugin of the waypoint follower",
    "NO_WAYPOINTS_GIVEN": "no waypoints given; expected at least one",
    "NO_VALID_WAYPOINTS": "no valid waypoints given; expected at least one",
    "STOP_ON_MISSED_WAYPOINT": "a waypoint was missed; look at the reason of its navigation",
}
_NAVIGATOR: Final = {
    **_COMMON,
    "FAILED_TO_LOAD_BEHAVIOR_TREE": "the behavior tree cannot be loaded; look at its file on the robot",
    "TIMEOUT": "a server did not answer in time; look at the load of the computer",
}
_DOCK: Final = {
    **_COMMON,
    "DOCK_NOT_IN_DB": "unknown dock; look at the docks of the docking server",
    "DOCK_NOT_VALID": "invalid type or pose of the dock; look at `dock_plugins` of the docking server",
    "FAILED_TO_STAGE": "the robot did not reach the staging pose in front of the dock",
    "FAILED_TO_DETECT_DOCK": "the dock was not detected; look at its marker, the camera and the light",
    "FAILED_TO_CONTROL": "the robot could not follow the path at the dock; look for obstacles",
    "FAILED_TO_CHARGE": "the robot is docked but does not charge; look at its contacts and /battery_state",
}
_FOLLOW: Final = {
    **_COMMON,
    "FAILED_TO_DETECT_OBJECT": "the object was not detected; look at the topic of its pose",
    "FAILED_TO_CONTROL": "the robot could not follow the object; look for obstacles",
}

# Names of consecutive codes from the number on, and their words.
_PLANNER: Final = (
    "UNKNOWN", "INVALID_PLANNER", "TF_ERROR", "START_OUTSIDE_MAP", "GOAL_OUTSIDE_MAP", "START_OCCUPIED",
    "GOAL_OCCUPIED", "TIMEOUT", "NO_VALID_PATH",
)  # fmt: skip
_TREE: Final = ("UNKNOWN", "FAILED_TO_LOAD_BEHAVIOR_TREE", "TF_ERROR", "TIMEOUT")
_RANGES: Final[Mapping[int, tuple[Mapping[str, str], tuple[str, ...]]]] = {
    1: (_GOALS, ("GOAL_REJECTED", "SEND_GOAL_FAILURE")),
    100: (
        _CONTROL,
        (
            "UNKNOWN", "INVALID_CONTROLLER", "TF_ERROR", "INVALID_PATH", "PATIENCE_EXCEEDED",
            "FAILED_TO_MAKE_PROGRESS", "NO_VALID_CONTROL", "CONTROLLER_TIMED_OUT", "TIMEOUT",
        ),
    ),
    200: (_PLAN, _PLANNER),
    300: (_PLAN, (*_PLANNER, "NO_VIAPOINTS_GIVEN")),
    400: (
        _ROUTE,
        (
            "UNKNOWN", "TF_ERROR", "NO_VALID_GRAPH", "INDETERMINANT_NODES_ON_GRAPH", "TIMEOUT", "NO_VALID_ROUTE",
            "OPERATION_FAILED", "INVALID_EDGE_SCORER_USE",
        ),
    ),
    500: (
        _SMOOTH,
        (
            "UNKNOWN", "INVALID_SMOOTHER", "TIMEOUT", "SMOOTHED_PATH_IN_COLLISION", "FAILED_TO_SMOOTH_PATH",
            "INVALID_PATH",
        ),
    ),
    600: (_WAYPOINTS, ("UNKNOWN", "TASK_EXECUTOR_FAILED")),
    603: (_WAYPOINTS, ("STOP_ON_MISSED_WAYPOINT",)),
    700: (_BEHAVIOR, ("UNKNOWN", "TIMEOUT", "TF_ERROR", "COLLISION_AHEAD")),
    710: (_BEHAVIOR, ("UNKNOWN", "TIMEOUT", "TF_ERROR", "INVALID_INPUT", "COLLISION_AHEAD")),
    720: (_BEHAVIOR, ("UNKNOWN", "TIMEOUT", "TF_ERROR", "COLLISION_AHEAD", "INVALID_INPUT")),
    730: (_BEHAVIOR, ("UNKNOWN", "TIMEOUT", "TF_ERROR")),
    740: (_BEHAVIOR, ("UNKNOWN", "TIMEOUT")),
    901: (
        _DOCK,
        (
            "DOCK_NOT_IN_DB", "DOCK_NOT_VALID", "FAILED_TO_STAGE", "FAILED_TO_DETECT_DOCK", "FAILED_TO_CONTROL",
            "FAILED_TO_CHARGE", "TIMEOUT",
        ),
    ),
    999: (_DOCK, ("UNKNOWN",)),
    9000: (_NAVIGATOR, _TREE),
    9100: (_NAVIGATOR, _TREE),
}  # fmt: skip
_CODES: Final = {
    first + offset: (name, words[name])
    for first, (words, names) in _RANGES.items()
    for offset, name in enumerate(names)
}
_OWN: Final[Mapping[str, Mapping[int, tuple[str, str]]]] = {
    "FollowObject": {
        code: (name, _FOLLOW[name])
        for code, name in (
            (901, "TF_ERROR"),
            (902, "FAILED_TO_DETECT_OBJECT"),
            (903, "FAILED_TO_CONTROL"),
            (904, "TIMEOUT"),
            (999, "UNKNOWN"),
        )
    },
    "FollowWaypoints": {602: ("NO_VALID_WAYPOINTS", _WAYPOINTS["NO_VALID_WAYPOINTS"])},
    "FollowGPSWaypoints": {602: ("NO_WAYPOINTS_GIVEN", _WAYPOINTS["NO_WAYPOINTS_GIVEN"])},
}
"""Codes that other actions use differently, or not at all."""


def find_error(action: str, code: int) -> tuple[str, str] | None:
    """Return the name and the words of an error code; None if it is unknown.

    Args:
        action: Name of the type without its package, such as `Spin`.
        code: The code.
    """
    return _OWN.get(action, {}).get(code) or _CODES.get(code)


def describe_failure(action: str, result: Mapping[str, Any]) -> str:
    """Return why a result of an action of Nav2 is a failure; empty for successes and without a reason.

    Args:
        action: Name of the type without its package, such as `Spin`.
        result: Members of the result, of any distribution.
    """
    code, text = int(result.get("error_code", 0)), str(result.get("error_msg", ""))
    missed: Sequence[Any] = result.get("missed_waypoints", ())
    parts = [f"missed waypoints: {', '.join(str(_index(each) + 1) for each in missed)}"] if len(missed) else []
    if code:
        name, words = find_error(action, code) or ("", "unknown error code")
        parts.append(f"{words} ({name}, error {code})" if name else f"{words} {code}")
    elif result.get("success") is False:
        parts.append("the robot reports no success")
    if parts and text:
        parts.append(f"Nav2: {text}")
    return "; ".join(parts)


def _index(missed: Any) -> int:
    """Return the index of a missed waypoint: a number in Humble, in a message of later distributions."""
    if not isinstance(missed, Mapping):
        return int(missed)
    return int(missed["waypoint_index"] if "waypoint_index" in missed else missed["index"])  # since Kilted, before
