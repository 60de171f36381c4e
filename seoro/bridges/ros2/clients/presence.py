"""Presence of the nodes, topics, services and actions that a scenario waits for."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from typing import assert_never

from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.participant import BRIDGE, GUARD, RosNode
from seoro.bridges.ros2.wire import Endpoint, Ros2Dds
from seoro.errors import UsageError
from seoro.runtime.contracts.ros2 import Wanted


class Presence:
    """Presence of entities in a system; those of its own session and of seoro's bridges do not count.

    Args:
        node: Node of the own session.
    """

    def __init__(self, node: RosNode) -> None:
        self._node = node
        self._own = node.node.session

    def resolved(self, wanted: Wanted) -> Wanted:
        """Return a wanted entity with full names.

        Raises:
            UsageError: A name is invalid, or the system does not announce nodes.
        """
        if (wanted.node or wanted.kind == "node") and isinstance(self._node.system.dialect, Ros2Dds):
            raise UsageError("a bridge for DDS robots does not announce nodes", help="wait for topics or services")
        node = full_name(wanted.node) if wanted.node else ""
        name = full_name(wanted.name) if wanted.kind == "node" else self._node.resolve(wanted.name)
        return Wanted(wanted.kind, name, node)

    def has(self, graph: RosGraph, wanted: Wanted) -> bool:
        """Return whether a wanted entity exists."""
        if wanted.kind == "node":
            return wanted.name in graph.nodes()
        return any(self._counts(each, wanted.node) for each in _endpoints(graph, wanted))

    def _counts(self, endpoint: Endpoint, node: str) -> bool:
        owner = endpoint.node
        if endpoint.session == self._own:
            return False
        if node:
            return owner is not None and owner.full_name == node
        return owner is None or owner.name not in (BRIDGE, GUARD)  # these wait for the robot, too

    def missing(self, wanted: Wanted) -> str:
        """Describe a missing entity, and entities with a similar name."""
        is_endpoint = wanted.kind in ("publisher", "subscription", "server")
        text = f"{wanted.kind} {'of ' if is_endpoint else ''}{wanted.name}"
        if wanted.node:
            text += f" in the node {wanted.node}"
        known = _names(self._node.graph, wanted)
        if wanted.name in known:
            return text
        near = get_close_matches(wanted.name, known, n=3)
        return f"{text} (similar: {', '.join(near)})" if near else text


def full_name(node: str) -> str:
    """Return the full name of a node, which is in the root if it has no namespace."""
    return node if node.startswith("/") else f"/{node}"


def _endpoints(graph: RosGraph, wanted: Wanted) -> tuple[Endpoint, ...]:
    match wanted.kind:
        case "topic":
            return graph.publishers(wanted.name) + graph.subscriptions(wanted.name)
        case "publisher":
            return graph.publishers(wanted.name)
        case "subscription":
            return graph.subscriptions(wanted.name)
        case "service" | "server":
            return graph.servers(wanted.name)
        case "action":
            return graph.action_servers(wanted.name)
        case "node":
            return ()
        case _:
            assert_never(wanted.kind)


def _names(graph: RosGraph, wanted: Wanted) -> Iterable[str]:
    match wanted.kind:
        case "node":
            return graph.nodes()
        case "service" | "server":
            return graph.services(hidden=True)
        case "action":
            return graph.actions()
        case "topic" | "publisher" | "subscription":
            return graph.topics(hidden=True)
        case _:
            assert_never(wanted.kind)
