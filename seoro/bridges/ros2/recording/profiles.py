"""QoS profiles in bags.

Policies are names since version 9 of bags; before, they were the numbers of rmw (rmw/types.h). Other values, such
as `system_default` or `unknown`, are read as the defaults of ROS 2.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Any, Final, TypeVar

import yaml

from seoro.bridges.ros2.wire import Durability, History, Liveliness, Qos, Reliability

P = TypeVar("P", bound=Enum)

_SECOND: Final = 1_000_000_000  # [ns]
_INFINITE: Final = {"sec": 9_223_372_036, "nsec": 854_775_807}  # RMW_DURATION_INFINITE
_MOST: Final = _INFINITE["sec"] * _SECOND + _INFINITE["nsec"]  # [ns]
_NUMBERS: Final[Mapping[int, Mapping[str, Enum]]] = {
    1: {
        "history": History.KEEP_LAST,
        "reliability": Reliability.RELIABLE,
        "durability": Durability.TRANSIENT_LOCAL,
        "liveliness": Liveliness.AUTOMATIC,
    },
    2: {
        "history": History.KEEP_ALL,
        "reliability": Reliability.BEST_EFFORT,
        "durability": Durability.VOLATILE,
    },
    3: {"liveliness": Liveliness.MANUAL_BY_TOPIC},
}


def profile(qos: Qos) -> dict[str, Any]:
    """Encode a QoS profile for `metadata.yaml`."""
    return {
        "history": qos.history.value,
        "depth": qos.depth,
        "reliability": qos.reliability.value,
        "durability": qos.durability.value,
        "deadline": _duration(qos.deadline),
        "lifespan": _duration(qos.lifespan),
        "liveliness": qos.liveliness.value,
        "liveliness_lease_duration": _duration(qos.lease),
        "avoid_ros_namespace_conventions": False,
    }


def read_profiles(written: str | list[Any]) -> tuple[Qos, ...]:
    """Decode the QoS profiles of the publishers of a topic: a list, or its text in YAML.

    Raises:
        ValueError: The list of profiles is invalid.
    """
    if isinstance(written, str):
        try:
            written = yaml.safe_load(written) or []
        except yaml.YAMLError as error:
            raise ValueError(f"invalid YAML of QoS profiles: {error}") from None
    if not isinstance(written, list) or not all(isinstance(each, dict) for each in written):
        raise ValueError("invalid QoS: expected a list of profiles")
    return tuple(_read(each) for each in written)


def _read(written: Mapping[str, Any]) -> Qos:
    default = Qos()
    depth = written.get("depth")
    return Qos(
        _policy(written, "reliability", default.reliability),
        _policy(written, "durability", default.durability),
        _policy(written, "history", default.history),
        depth if isinstance(depth, int) and 0 < depth < 1 << 31 else default.depth,
        _nanoseconds(written.get("deadline")),
        _nanoseconds(written.get("lifespan")),
        _policy(written, "liveliness", default.liveliness),
        _nanoseconds(written.get("liveliness_lease_duration")),
    )


def _policy(written: Mapping[str, Any], name: str, default: P) -> P:
    value = written.get(name)
    if isinstance(value, int):
        found = _NUMBERS.get(value, {}).get(name, default)
        return found if isinstance(found, type(default)) else default
    return next((policy for policy in type(default) if policy.value == value), default)


def _duration(nanoseconds: int | None) -> dict[str, int]:
    if nanoseconds is None:
        return dict(_INFINITE)
    return {"sec": nanoseconds // _SECOND, "nsec": nanoseconds % _SECOND}


def _nanoseconds(written: Any) -> int | None:
    if not isinstance(written, dict):
        return None
    seconds, rest = written.get("sec"), written.get("nsec")
    if not isinstance(seconds, int) or not isinstance(rest, int):
        return None
    nanoseconds = seconds * _SECOND + rest
    return nanoseconds if 0 < nanoseconds < _MOST else None
