"""ROS messages as text: the methods of the struct `msg_conversion` in `osc.ros`, and what actions read.

A message is text here: YAML, as `ros2 topic echo` prints it and `ros2 topic pub` reads it, or JSON, which is
YAML too.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from seoro.errors import InvalidUse
from seoro.runtime.contracts import (
    Orientation3D,
    OrientationRate3D,
    Pose3D,
    Position3D,
    TranslationalVelocity3D,
    Velocity6D,
)

MAX_SIZE = 256 * 1024  # characters; a message that a scenario looks into is far smaller


def get_object_member(in_value: str, member_name: str) -> str:
    """A member of a message: a number or a text as it is, anything else as JSON.

    Args:
        in_value: The message.
        member_name: Path of the member, such as `pose.position.x`; elements of lists by their numbers from 0. The
            whole message if it is empty.

    Raises:
        InvalidUse: The text is no message, or has no such member.
    """
    found = member_of(read_message(in_value), member_name)
    return found if isinstance(found, str) else json.dumps(found, default=str)


def member_of(message: Any, path: str) -> Any:
    """A member of a message, which is a mapping of its members; see `get_object_member`.

    Raises:
        InvalidUse: It has none of that name.
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
            raise InvalidUse(f"there is no '{name}' of '{path}'; there are {', '.join(map(str, value))}")
        case list():
            raise InvalidUse(f"there is no '{name}' of '{path}' in a list of {len(value)}")
        case _:
            raise InvalidUse(f"there is no '{name}' of '{path}': what is before it has no members")


def to_pose_3d(in_value: str) -> Pose3D:
    """The pose of a `geometry_msgs` message: `Pose`, or one that has a `pose`, with a covariance or a stamp.

    Raises:
        InvalidUse: The text is no such message.
    """
    found = read_message(in_value)
    while isinstance(found, dict) and "position" not in found and "pose" in found:
        found = found["pose"]
    if not isinstance(found, dict) or not {"position", "orientation"} <= found.keys():
        raise InvalidUse("this is no pose: it has no `position` and `orientation`")
    x, y, z = _numbers(found["position"], "xyz")
    return Pose3D(Position3D(x, y, z), _angles(*_numbers(found["orientation"], "xyzw")))


def to_twist(message: Mapping[str, Any]) -> Velocity6D:
    """The velocity of a `geometry_msgs` message: `Twist`, or `TwistStamped`; what it leaves out is 0.

    Raises:
        InvalidUse: It is no such message.
    """
    found = message.get("twist", message)
    if not isinstance(found, Mapping) or not found.keys() <= {"linear", "angular"}:
        raise InvalidUse("this is no twist: it has parts other than `linear` and `angular`, or none")
    still = {"x": 0.0, "y": 0.0, "z": 0.0}
    for part in found.values():
        if not isinstance(part, Mapping) or not part.keys() <= still.keys():
            raise InvalidUse("this is no twist: its parts have `x`, `y` and `z`")
    linear, angular = ({**still, **found.get(part, {})} for part in ("linear", "angular"))
    return Velocity6D(
        TranslationalVelocity3D(*_numbers(linear, "xyz", "twist")),
        OrientationRate3D(*_numbers(angular, "xyz", "twist")),
    )


def _numbers(value: Any, names: str, what: str = "pose") -> tuple[float, ...]:
    if not isinstance(value, Mapping) or not all(isinstance(value.get(name), int | float) for name in names):
        raise InvalidUse(f"this is no {what}: `{', '.join(names)}` are not all numbers")
    return tuple(float(value[name]) for name in names)


def _angles(x: float, y: float, z: float, w: float) -> Orientation3D:
    """Roll, pitch and yaw of a quaternion, yaw first (ISO 8855); its length does not matter.

    The angles are read from the elements of the rotation matrix, each multiplied by the square of the length.
    """
    square = x * x + y * y + z * z + w * w
    if not math.isfinite(square) or square == 0:
        raise InvalidUse("this is no pose: its quaternion has no direction")
    return Orientation3D(
        roll=math.atan2(2 * (y * z + w * x), w * w - x * x - y * y + z * z),
        pitch=math.asin(max(-1.0, min(1.0, 2 * (w * y - x * z) / square))),
        yaw=math.atan2(2 * (x * y + w * z), w * w + x * x - y * y - z * z),
    )


def _members(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    members = dict(pairs)
    if len(members) < len(pairs):
        raise ValueError("a member is given twice")  # where, is told of the text as YAML
    return members


def read_message(text: str) -> Any:
    """What a text says, in YAML or JSON.

    Raises:
        InvalidUse: It cannot be read.
    """
    if len(text) > MAX_SIZE:
        raise InvalidUse(f"the message is longer than {MAX_SIZE} characters")
    try:
        return json.loads(text, object_pairs_hook=_members)  # which is sooner read than YAML
    except (ValueError, RecursionError):
        pass
    from seoro.plain_yaml import read_yaml  # noqa: PLC0415 - slow to load, and seldom needed

    try:
        return read_yaml(text.removesuffix("\n---"))
    except ValueError as error:
        raise InvalidUse(f"the message cannot be read: {error}") from error
