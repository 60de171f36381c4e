"""Profiles of surveyed robots, with notes on where each value comes from."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, Final

from seoro.bridges.ros2.adoption.arms import draft_arm
from seoro.bridges.ros2.adoption.draft import CHECK, Draft
from seoro.bridges.ros2.adoption.survey import Survey
from seoro.bridges.ros2.robots.profile import available_profiles
from seoro.bridges.ros2.wire import Endpoint

BASE_KINDS: Final = ("differential_drive_robot",)
ARM_KINDS: Final = ("manipulator", "arm")
EVERY_KIND: Final = ("robot", "osc_actor")
CAUTIOUS: Final = {"linear": 0.2, "angular": 0.5}  # [m/s, rad/s]
_UNITS: Final = {"linear": "forward speed [m/s]", "angular": "turn rate [rad/s]"}
_SPEEDS: Final = (
    # Parameters of the base's controller come first: they bind all commands.
    ("", "linear.x.max_velocity", "angular.z.max_velocity"),
    ("", "max_linear_speed", "max_angular_speed"),
    ("velocity_smoother", "max_velocity", "max_velocity"),
    ("controller_server", "FollowPath.max_vel_x", "FollowPath.max_vel_theta"),
    ("controller_server", "FollowPath.vx_max", "FollowPath.wz_max"),
    ("controller_server", "FollowPath.desired_linear_vel", "FollowPath.rotate_to_heading_angular_vel"),
)
_NAVIGATION: Final = ("navigate_to_pose", "navigate_through_poses", "follow_waypoints")
_LOCALISATION: Final = ("initial_pose", "pose", "global_localization")


def draft_profile(survey: Survey) -> Draft:
    """Draft the profile of a robot."""
    robot, draft = survey.robot, Draft()
    draft.put(("model",), model_name(survey))
    draft.put(("kinds",), list(EVERY_KIND))
    for name in ("tf", "tf_static", "battery"):
        if name in robot:
            _put_name(draft, (name,), survey, name)
    has_base = "cmd_vel" in robot or "navigate_to_pose" in robot
    if has_base:
        _draft_base(draft, survey)
    has_arm = "trajectory" in robot and draft_arm(draft, survey)
    draft.put(("kinds",), [*_kinds(has_base=has_base, has_arm=has_arm)])
    _draft_sensors(draft, survey)
    draft.remarks += _remarks(survey)
    return draft


def model_name(survey: Survey) -> str:
    """Return a name for a robot: its namespace, else that of its description."""
    links = survey.links
    name = survey.robot.namespace.rpartition("/")[2] or ("" if links is None else links.robot)
    plain = re.sub(r"[^a-z0-9_]+", "_", name.lower()).strip("_")[:64]
    return plain if plain[:1].isalpha() else f"robot_{plain}".rstrip("_")


def _kinds(*, has_base: bool, has_arm: bool) -> Iterator[str]:
    if has_base and has_arm:
        yield "mobile_manipulator"
    if has_base:
        yield from BASE_KINDS
    if has_arm:
        yield from ARM_KINDS
    yield from EVERY_KIND


def _put_name(draft: Draft, place: tuple[str, ...], survey: Survey, part: str) -> None:
    """Set the name of a topic, service or action, with its type, node and alternatives."""
    chosen, *others = survey.robot.parts[part]
    more = dict.fromkeys(each.name for each in others if each.name != chosen.name)
    note = _described(chosen) + (f"; also found: {', '.join(more)}" if more else "")
    draft.put(place, survey.robot.relative(chosen.name), note)


def _described(endpoint: Endpoint) -> str:
    owner = "" if endpoint.node is None else f" of {endpoint.node.full_name}"
    return f"found: {endpoint.name}{owner}, {endpoint.type}"


def _draft_base(draft: Draft, survey: Survey) -> None:
    _draft_limits(draft, survey)
    for part in ("cmd_vel", "odometry", *_LOCALISATION, *_NAVIGATION):
        if part in survey.robot:
            _put_name(draft, ("base", part), survey, part)
    frames = {
        node: survey.parameters_named(node).get(parameter)
        for node, parameter in (("bt_navigator", "global_frame"), ("amcl", "global_frame_id"))
    }
    for node, frame in frames.items():
        if isinstance(frame, str) and frame:
            draft.put(("base", "map_frame"), frame, f"parameter of {node}")
            break


def _draft_limits(draft: Draft, survey: Survey) -> None:
    for index, axis in enumerate(("linear", "angular")):
        place = ("base", "limits", axis)
        for node, *names in _SPEEDS:
            known = survey.parameters_named(node) if node else survey.parameters_of("cmd_vel")
            speed = _speed(known.get(names[index]), index)
            if speed is not None:
                draft.put(place, speed, f"parameter {names[index]} of {node or 'the node of cmd_vel'}")
                break
        else:
            draft.ask(f"maximum {_UNITS[axis]}", CAUTIOUS[axis], place)


def _speed(value: Any, index: int) -> float | None:
    """Return a positive speed from a parameter: a number, or a list of those along x, along y and about z."""
    if isinstance(value, list | tuple) and len(value) == 3:
        value = value[(0, 2)[index]]
    is_speed = isinstance(value, int | float) and not isinstance(value, bool) and 0.0 < value < 100.0
    return round(float(value), 4) if is_speed else None


def _draft_sensors(draft: Draft, survey: Survey) -> None:
    robot = survey.robot
    for each in robot.parts.get("force", ()):
        draft.put(("sensors", "force", sensor_name(each.name, "wrench")), robot.relative(each.name))
    for each in robot.parts.get("sight", ()):
        place = ("sensors", "sight", sensor_name(each.name, "detections"))
        draft.put((*place, "topic"), robot.relative(each.name), _described(each))
        size = _picture_size(survey, each.name)
        if size is not None:
            for key, pixels in size.items():
                draft.put((*place, key), pixels, "of its camera_info")


def sensor_name(topic: str, usual: str) -> str:
    """Return a name for a sensor: the last part of its topic that is more specific than its kind."""
    above, _, last = topic.rpartition("/")
    return (above.rpartition("/")[2] or last) if last == usual else last


def _picture_size(survey: Survey, topic: str) -> Mapping[str, int] | None:
    """Return the size of the pictures of a detector [pixels]: those of the camera beside it, or the only one."""
    cameras = {each.name for each in survey.robot.parts.get("camera", ())}
    beside = {name for name in cameras if name.rpartition("/")[0] == topic.rpartition("/")[0]}
    [*chosen] = beside or cameras
    info = survey.messages.get(chosen[0]) if len(chosen) == 1 else None
    return None if info is None else {"width": int(info.width), "height": int(info.height)}


# ------------------------------------------------------------------------------------------------ remarks


def _remarks(survey: Survey) -> Iterator[str]:
    robot = survey.robot
    odometry = survey.message("odometry")
    if "odometry" in robot and odometry is None:
        yield f"{CHECK}: no message arrived on {robot.name('odometry')}"
    if odometry is not None and odometry.header.frame_id:
        yield f"{robot.name('odometry')} has poses of {odometry.child_frame_id!r} in {odometry.header.frame_id!r}"
    if survey.parents:
        yield f"frames (child in parent): {', '.join(f'{a} in {b}' for a, b in sorted(survey.parents.items()))}"
    for each in dict.fromkeys(each.name for each in robot.parts.get("lidar", ())):
        scan = survey.messages.get(each)
        yield f"lidar: {each}" + ("" if scan is None else f" in frame {scan.header.frame_id!r}")
    for each in dict.fromkeys(each.name for each in robot.parts.get("camera", ())):
        info = survey.messages.get(each)
        yield f"camera: {each}" + ("" if info is None else f", {info.width} by {info.height} pixels")
    for each in dict.fromkeys(each.name for each in robot.parts.get("imu", ())):
        yield f"IMU: {each}"
    if "cmd_vel" in robot and not any(part in robot for part in _NAVIGATION):
        yield "no navigation was visible: start Nav2 before scenarios with `nav_to_pose`"
    if model_name(survey) in available_profiles():
        yield f"seoro has a profile of the name '{model_name(survey)}': compare it with this one"
