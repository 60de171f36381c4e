"""Structs of a scenario as members of ROS messages.

Members keep their names, except where `geometry_msgs` differs: angles become a quaternion, `translational` becomes
`linear`, and rates about axes become `x`, `y` and `z`.
"""

from __future__ import annotations

from collections.abc import Mapping

from seoro.lang.plan import EnumValue
from seoro.robotics.geometry import quaternion
from seoro.runtime.values.values import Struct, Value, plain

_RENAMED: Mapping[str, str] = {"translational": "linear"}


def of_struct(struct: Struct) -> dict[str, object]:
    """Return the members of the message that corresponds to a struct."""
    names = {name.rpartition("::")[2] for name in struct.types}
    fields = struct.fields
    if "orientation_3d" in names:
        return quaternion(*(float(fields[name]) for name in ("roll", "pitch", "yaw")))._asdict()  # type: ignore[arg-type]
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
