"""The two mappings of ROS 2 to Zenoh, and their names on command lines."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from seoro.bridges.ros2.wire.rmw_zenoh import RmwZenoh
from seoro.bridges.ros2.wire.ros2dds import Ros2Dds
from seoro.errors import UsageError

Dialect: TypeAlias = RmwZenoh | Ros2Dds
"""Mapping of ROS 2 to Zenoh. Both classes have the same methods."""

_DIALECTS: dict[str, Callable[[int], Dialect]] = {"rmw_zenoh": RmwZenoh, "ros2dds": lambda domain: Ros2Dds()}


def named_dialect(name: str | None, domain: int) -> Dialect | None:
    """Return the dialect of a name; None to detect the dialect.

    Args:
        name: `rmw_zenoh`, `ros2dds` or None.
        domain: ROS_DOMAIN_ID; a bridge for DDS has its own.

    Raises:
        UsageError: Unknown dialect.
    """
    if name is None:
        return None
    if name not in _DIALECTS:
        raise UsageError(f"unknown dialect '{name}'", help=f"dialects: {', '.join(_DIALECTS)}")
    return _DIALECTS[name](domain)
