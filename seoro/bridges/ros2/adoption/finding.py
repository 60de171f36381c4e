"""Robots in the graph of a ROS 2 system: namespaces in which velocities, trajectories or goals are accepted."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.robots.parts import PARTS, Part, all_endpoints, is_of_bridge
from seoro.bridges.ros2.wire import Endpoint

CONTROLLER: Final = (
    "controller"  # last word of names of ros2_control's nodes, which are below the robot's namespace
)
MOVED_BY: Final = ("cmd_vel", "navigate_to_pose", "trajectory")  # parts that make a namespace a robot
SHARED: Final = ("tf", "tf_static", "description", "semantics")  # of the root, if the namespace has none


@dataclass(frozen=True)
class FoundRobot:
    """A robot of a system.

    Attributes:
        namespace: Namespace of its names.
        parts: Endpoints by the names of parts, the most likely one first; parts that it lacks are left out.
    """

    namespace: str
    parts: Mapping[str, tuple[Endpoint, ...]]

    def __contains__(self, part: str) -> bool:
        return part in self.parts

    def name(self, part: str) -> str:
        """Return the full name of a present part."""
        return self.parts[part][0].name

    def relative(self, full: str) -> str:
        """Return a name as a profile states it: below the namespace without a leading slash."""
        prefix = _prefix(self.namespace)
        return full.removeprefix(prefix) if full.startswith(prefix) else full

    @property
    def nodes(self) -> tuple[str, ...]:
        """Full names of the nodes of its parts, sorted; none behind a bridge for DDS."""
        named = {each.node.full_name for found in self.parts.values() for each in found if each.node is not None}
        return tuple(sorted(named))


def find_robots(graph: RosGraph, own: str) -> tuple[FoundRobot, ...]:
    """Return the robots of a system, by their namespaces.

    Args:
        graph: Graph of the system.
        own: Zenoh ID of the own session. Its endpoints, and those of bridges of seoro, do not count.
    """
    known = [each for each in all_endpoints(graph) if each.session != own and not is_of_bridge(each)]
    found = {name: [each for each in known if _fits(part, each)] for name, part in PARTS.items()}
    homes = _without_nested({_home(each) for name in MOVED_BY for each in found[name]})
    return tuple(_robot(home, homes, found) for home in sorted(homes))


def _fits(part: Part, endpoint: Endpoint) -> bool:
    is_named = not part.is_named or _last(endpoint.name) in part.names
    return endpoint.kind is part.kind and endpoint.type in part.types and is_named


def _home(endpoint: Endpoint) -> str:
    """Return the namespace of the robot of an endpoint: above private names and controllers."""
    above = _above(endpoint.name)
    node = endpoint.node
    if node is not None and above == node.full_name:
        return node.namespace
    while _last(above).endswith(CONTROLLER):
        above = _above(above)
    return above


def _without_nested(homes: set[str]) -> set[str]:
    """Leave out namespaces below that of another robot. The root may have the robots of a fleet below it."""
    return {
        home
        for home in homes
        if not any(other not in ("/", home) and home.startswith(_prefix(other)) for other in homes)
    }


def _robot(home: str, homes: set[str], found: Mapping[str, Sequence[Endpoint]]) -> FoundRobot:
    others = [_prefix(other) for other in homes if other != home and other.startswith(_prefix(home))]

    def is_own(endpoint: Endpoint) -> bool:
        return endpoint.name.startswith(_prefix(home)) and not endpoint.name.startswith(tuple(others))

    parts: dict[str, tuple[Endpoint, ...]] = {}
    for name, endpoints in found.items():
        own = [each for each in endpoints if is_own(each)]
        if not own and name in SHARED:
            own = [each for each in endpoints if _above(each.name) == "/"]
        if own:
            parts[name] = tuple(sorted(own, key=_preference(PARTS[name], found)))
    return FoundRobot(home, parts)


def _preference(part: Part, found: Mapping[str, Sequence[Endpoint]]) -> Callable[[Endpoint], tuple[object, ...]]:
    """Return a key that sorts usual names first, then endpoints of nodes with odometry, then short names."""
    drivers = {each.node.full_name for each in found["odometry"] if each.node is not None}

    def key(endpoint: Endpoint) -> tuple[object, ...]:
        last = _last(endpoint.name)
        rank = part.names.index(last) if last in part.names else len(part.names)
        is_driver = endpoint.node is not None and endpoint.node.full_name in drivers
        return rank, not is_driver, endpoint.name.count("/"), endpoint.name

    return key


def _prefix(namespace: str) -> str:
    return "/" if namespace == "/" else f"{namespace}/"


def _above(name: str) -> str:
    return name.rpartition("/")[0] or "/"


def _last(name: str) -> str:
    return name.rpartition("/")[2]
