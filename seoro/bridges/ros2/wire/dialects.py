"""The dialects by the names that people give on command lines."""

from __future__ import annotations

from collections.abc import Callable

from seoro.bridges.ros2.wire.dialect import Dialect
from seoro.bridges.ros2.wire.rmw_zenoh import RmwZenoh
from seoro.bridges.ros2.wire.ros2dds import Ros2Dds
from seoro.errors import InvalidUse

_DIALECTS: dict[str, Callable[[int], Dialect]] = {"rmw_zenoh": RmwZenoh, "ros2dds": lambda domain: Ros2Dds()}


def named_dialect(name: str | None, domain: int) -> Dialect | None:
    """The dialect of a name.

    Args:
        name: `rmw_zenoh` or `ros2dds`; None to find out what is spoken.
        domain: ROS_DOMAIN_ID; a bridge for DDS has its own.

    Raises:
        InvalidUse: There is no such dialect.
    """
    if name is None:
        return None
    if name not in _DIALECTS:
        raise InvalidUse(f"there is no dialect '{name}'", help=f"dialects: {', '.join(_DIALECTS)}")
    return _DIALECTS[name](domain)
