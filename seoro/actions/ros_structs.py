"""Structs of a scenario as members of messages of ROS.

Members keep their names, but for what `geometry_msgs` says otherwise: angles become a quaternion, `translational`
is `linear`, and rates about the axes are called like these.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from seoro.lang.plan import EnumValue
from seoro.runtime.values import Struct, Value, plain

_RENAMED: Mapping[str, str] = {"translational": "linear"}


def of_struct(struct: Struct) -> dict[str, object]:
    """The members of a message that a struct stands for."""
    names = {name.rpartition("::")[2] for name in struct.types}
    fields = struct.fields
    if "orientation_3d" in names:
        return _quaternion(*(float(fields[name]) for name in ("roll", "pitch", "yaw")))  # type: ignore[arg-type]
    if names & {"orientation_rate_3d", "orientation_acceleration_3d"}:
        return {"x": fields["roll"], "y": fields["pitch"], "z": fields["yaw"]}
    return {_RENAMED.get(name, name): _value(value) for name, value in fields.items()}


def _value(value: Value) -> object:
    match value:
        case Struct():
            return of_struct(value)
        case EnumValue():
            return value.number
        case tuple():
            return [_value(item) for item in value]
        case _:
            return plain(value)


def _quaternion(roll: float, pitch: float, yaw: float) -> dict[str, object]:
    """Of rotations about the fixed axes x, y and z, in this order: the product of those of yaw, pitch and roll."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(half), math.sin(half)) for half in (roll / 2, pitch / 2, yaw / 2))
    return {
        "x": sr * cp * cy - cr * sp * sy,
        "y": cr * sp * cy + sr * cp * sy,
        "z": cr * cp * sy - sr * sp * cy,
        "w": cr * cp * cy + sr * sp * sy,
    }
