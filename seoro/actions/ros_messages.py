"""ROS messages as text: the methods of the struct `msg_conversion` in `osc.ros`, and the reader for actions.

Messages are YAML text, as printed by `ros2 topic echo` and read by `ros2 topic pub`, or JSON, a subset of YAML.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from seoro.errors import UsageError
from seoro.robotics import geometry

MAX_SIZE = 256 * 1024  # characters; typical messages are far smaller


def get_object_member(in_value: str, member_name: str) -> str:
    """Return a member of a message: numbers and strings as they are, anything else as JSON.

    Args:
        in_value: The message.
        member_name: Path of the member, such as `pose.position.x`; list elements by index. Empty for the whole
            message.

    Raises:
        UsageError: The text is invalid, or the member is missing.
    """
    found = member_of(read_message(in_value), member_name)
    return found if isinstance(found, str) else json.dumps(found, default=str)


def member_of(message: Any, path: str) -> Any:
    """Return a member of a message given as a mapping; see `get_object_member`.

    Raises:
        UsageError: The member is missing.
    """
    found = message
    for name in path.split(".") if path else ():
        found = _member(found, name, path)
    return found


def _member(value: Any, name: str, path: str) -> Any:
    match value:
        case Mapping() if name in value:
            return value[name]
        case list() if name.isdecimal() and int(name) < len(value):
            return value[int(name)]
        case Mapping():
            raise UsageError(f"unknown member '{name}' in '{path}' (members: {', '.join(map(str, value))})")
        case list():
            raise UsageError(f"unknown index '{name}' in '{path}': the list has {len(value)} elements")
        case _:
            raise UsageError(f"unknown member '{name}' in '{path}': the value before it has no members")


def to_pose_3d(in_value: str) -> geometry.Pose3D:
    """Return the pose of a `geometry_msgs` message: `Pose`, or a message with a member `pose`.

    Raises:
        UsageError: The message has no pose.
    """
    found = read_message(in_value)
    while isinstance(found, dict) and "position" not in found and "pose" in found:
        found = found["pose"]
    if not isinstance(found, dict) or not {"position", "orientation"} <= found.keys():
        raise UsageError("invalid pose: expected the members `position` and `orientation`")
    x, y, z = _numbers(found["position"], "xyz")
    return geometry.Pose3D(geometry.Position3D(x, y, z), _angles(*_numbers(found["orientation"], "xyzw")))


def to_twist(message: Mapping[str, Any]) -> geometry.Velocity6D:
    """Return the velocity of a `geometry_msgs` message, `Twist` or `TwistStamped`; missing members are 0.

    Raises:
        UsageError: The message is invalid.
    """
    found = message.get("twist", message)
    if not isinstance(found, Mapping) or not found.keys() <= {"linear", "angular"}:
        raise UsageError("invalid twist: expected the members `linear` and `angular` only")
    still = {"x": 0.0, "y": 0.0, "z": 0.0}
    for part in found.values():
        if not isinstance(part, Mapping) or not part.keys() <= still.keys():
            raise UsageError("invalid twist: expected parts with the members `x`, `y` and `z` only")
    linear, angular = ({**still, **found.get(part, {})} for part in ("linear", "angular"))
    return geometry.Velocity6D(
        geometry.TranslationalVelocity3D(*_numbers(linear, "xyz", "twist")),
        geometry.OrientationRate3D(*_numbers(angular, "xyz", "twist")),
    )


def _numbers(value: Any, names: str, what: str = "pose") -> tuple[float, ...]:
    if not isinstance(value, Mapping) or not all(isinstance(value.get(name), int | float) for name in names):
        raise UsageError(f"invalid {what}: expected numbers for `{', '.join(names)}`")
    return tuple(float(value[name]) for name in names)


def _angles(x: float, y: float, z: float, w: float) -> geometry.Orientation3D:
    """Return roll, pitch and yaw of a quaternion of any length, yaw first (ISO 8855).

    The angles are computed from elements of the rotation matrix, each multiplied by the square of the length.
    """
    square = x * x + y * y + z * z + w * w
    if not math.isfinite(square) or square == 0:
        raise UsageError("invalid pose: its quaternion has no direction")
    return geometry.Orientation3D(
        roll=math.atan2(2 * (y * z + w * x), w * w - x * x - y * y + z * z),
        pitch=math.asin(max(-1.0, min(1.0, 2 * (w * y - x * z) / square))),
        yaw=math.atan2(2 * (x * y + w * z), w * w + x * x - y * y - z * z),
    )


def _members(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    members = dict(pairs)
    if len(members) < len(pairs):
        raise ValueError("duplicate member")  # reported with its place when read as YAML
    return members


def read_message(text: str) -> Any:
    """Read a message in YAML or JSON.

    Raises:
        UsageError: The text is invalid.
    """
    if len(text) > MAX_SIZE:
        raise UsageError(f"the message is too long: expected at most {MAX_SIZE} characters, found {len(text)}")
    try:
        return json.loads(text, object_pairs_hook=_members)  # faster than YAML
    except (ValueError, RecursionError):
        pass
    from seoro.files.plain_yaml import read_yaml  # noqa: PLC0415 - slow to load, and seldom needed

    try:
        return read_yaml(text.removesuffix("\n---"))
    except ValueError as error:
        raise UsageError(f"cannot read the message: {error}") from error
