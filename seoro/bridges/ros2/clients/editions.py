"""Requests and goals for servers whose definitions differ between distributions of ROS 2."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from seoro.bridges.ros2.interfaces import InvalidDefinition, InvalidValue, TypeStore, UnknownInterface
from seoro.bridges.ros2.interfaces.definitions import Named

GOALS = "nav_msgs/msg/Goals"  # poses of Nav2 since Kilted; a list of poses before


def check_fits(types: TypeStore, name: str, value: Mapping[str, Any]) -> None:
    """Check that a message can be sent to servers of some distribution, before any wait.

    Raises:
        UsageError: It fits no known edition of the interface; the error is that of `types`.
    """
    try:
        types.encode(name, value)
    except InvalidValue:
        if not any(_fits(edition, name, value) for edition in types.editions(name)):
            raise


def _fits(types: TypeStore, name: str, value: Mapping[str, Any]) -> bool:
    try:
        types.encode(name, adapt(types, name, value))
    except (InvalidValue, InvalidDefinition, UnknownInterface):
        return False
    return True


def adapt(types: TypeStore, name: str, value: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a message in the form of an edition: lists of stamped poses become `nav_msgs/msg/Goals` there."""
    names = [field.name for field in types.structure(name).fields if field.type == Named(GOALS)]
    return {**value, **{each: _goals(value[each]) for each in names if isinstance(value.get(each), list | tuple)}}


def _goals(poses: Sequence[Mapping[str, Any]]) -> Mapping[str, Any]:
    return {"header": poses[0].get("header", {}) if poses else {}, "goals": poses}
