"""Places in the arguments of actions, from the records of a trace."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Final, NamedTuple

from seoro.robotics.geometry import quaternion

Record = Mapping[str, Any]

_POSE: Final = "pose_3d"
_POSITION: Final = "position_3d"
_UNTURNED: Final = (0.0, 0.0, 0.0, 1.0)


class Place(NamedTuple):
    """A place that an action was given.

    Args:
        pose: x, y, z [m] and a quaternion x, y, z, w in `map`.
        is_pose: Whether the orientation was given, too.
    """

    pose: tuple[float, ...]
    is_pose: bool


class Places:
    """Poses and positions among the values of instances. Objects are described once, and have numbers later."""

    def __init__(self) -> None:
        self._objects: dict[int, Record] = {}

    def of(self, values: Mapping[str, Any]) -> Iterator[Place]:
        """Yield the places among the arguments of an action, also those in lists."""
        for value in values.values():
            for each in value if isinstance(value, list) else [value]:
                found = self._described(each)
                if found is None:
                    continue
                if _POSE in found["types"]:
                    yield Place(
                        (*self._position(found["fields"].get("position")), *self._turn(found)), is_pose=True
                    )
                elif _POSITION in found["types"]:
                    yield Place((*self._position(found), *_UNTURNED), is_pose=False)

    def _described(self, value: Any) -> Record | None:
        """Return the description of an object; learn those in its fields."""
        if not isinstance(value, Mapping) or "object" not in value:
            return None
        if "fields" in value:
            self._objects[value["object"]] = value
            for field in value["fields"].values():
                self._described(field)
        return self._objects.get(value["object"])

    def _position(self, value: Any) -> tuple[float, float, float]:
        found = self._described(value)
        fields = {} if found is None else found["fields"]
        return fields.get("x", 0.0), fields.get("y", 0.0), fields.get("z", 0.0)

    def _turn(self, pose: Record) -> tuple[float, ...]:
        found = self._described(pose["fields"].get("orientation"))
        fields = {} if found is None else found["fields"]
        return quaternion(fields.get("roll", 0.0), fields.get("pitch", 0.0), fields.get("yaw", 0.0))
