"""Whether things are there that a scenario waits for: nodes, topics, services, actions, and who has them."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from typing import assert_never

from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.own_nodes import BRIDGE, GUARD
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.wire import Endpoint, Node, Ros2Dds
from seoro.errors import InvalidUse
from seoro.runtime.ros_system import Wanted


class Presence:
    """Looks for things in a system; those of its own session and of seoro's bridges do not count.

    Args:
        node: Who looks.
    """

    def __init__(self, node: RosNode) -> None:
        self._node = node
        self._own = node.node.session

    def resolved(self, wanted: Wanted) -> Wanted:
        """The same by full names.

        Raises:
            InvalidUse: The names cannot be such, or nothing can be said of nodes here.
        """
        if (wanted.node or wanted.kind == "node") and isinstance(self._node.system.dialect, Ros2Dds):
            raise InvalidUse("a bridge for DDS robots does not tell of nodes", help="wait for topics or services")
        node = full_name(wanted.node) if wanted.node else ""
        name = full_name(wanted.name) if wanted.kind == "node" else self._node.resolve(wanted.name)
        return Wanted(wanted.kind, name, node)

    def has(self, graph: RosGraph, wanted: Wanted) -> bool:
        """Whether something is there."""
        match wanted.kind:
            case "node":
                return wanted.name in graph.nodes()
            case "topic":
                return self._is_any(graph.publishers(wanted.name)) or self._is_any(
                    graph.subscriptions(wanted.name)
                )
            case "service":
                return self._is_any(graph.servers(wanted.name))
            case "action":
                return self._is_any(graph.action_servers(wanted.name))
            case "publisher":
                return self._is_any(graph.publishers(wanted.name), wanted.node)
            case "subscription":
                return self._is_any(graph.subscriptions(wanted.name), wanted.node)
            case "server":
                return self._is_any(graph.servers(wanted.name), wanted.node)
            case _:
                assert_never(wanted.kind)

    def _is_any(self, endpoints: Iterable[Endpoint], node: str = "") -> bool:
        def is_it(owner: Node | None) -> bool:
            if node:
                return owner is not None and owner.full_name == node
            return owner is None or owner.name not in (BRIDGE, GUARD)  # who wait for the robot themselves

        return any(each.session != self._own and is_it(each.node) for each in endpoints)

    def missing(self, wanted: Wanted) -> str:
        """That something is not there, and what is there of a similar name."""
        graph = self._node.graph
        what = (
            f"{wanted.kind} {wanted.name}"
            if wanted.kind in ("node", "topic", "service", "action")
            else (f"{wanted.kind} of {wanted.name}")
        )
        if wanted.node:
            what += f" in the node {wanted.node}"
        known = _names(graph, wanted)
        if wanted.name in known:
            return what
        near = get_close_matches(wanted.name, known, n=3)
        return f"{what} (there is {', '.join(near)})" if near else what


def full_name(node: str) -> str:
    """The full name of a node: one without a namespace is in the root."""
    return node if node.startswith("/") else f"/{node}"


def _names(graph: RosGraph, wanted: Wanted) -> Iterable[str]:
    match wanted.kind:
        case "node":
            return graph.nodes()
        case "topic" | "publisher" | "subscription":
            return graph.topics(hidden=True)
        case "service" | "server":
            return graph.services(hidden=True)
        case "action":
            return graph.actions()
        case _:
            assert_never(wanted.kind)
