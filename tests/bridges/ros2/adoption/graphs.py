"""Graphs of ROS 2 systems for tests."""

from __future__ import annotations

from collections.abc import Iterable

from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.robots.parts import PARTS
from seoro.bridges.ros2.wire import Endpoint, Kind, Node, Qos, RmwZenoh

DIALECT = RmwZenoh()


def graph_of(entities: Iterable[tuple[str, str, str]], session: str = "aa") -> RosGraph:
    """Return a graph with the endpoints of nodes: full name of the node, part of a robot, full name."""
    graph = RosGraph(DIALECT)
    for number, (owner, part, name) in enumerate(entities):
        graph.change([(_token(session, number, owner, part, name), True)])
    return graph


def _token(session: str, number: int, owner: str, part: str, name: str) -> str:
    kind, type_name = PARTS[part].kind, PARTS[part].types[0]
    if kind is Kind.ACTION_SERVER:
        kind, type_name, name = Kind.SERVER, f"{type_name}_SendGoal", f"{name}/_action/send_goal"
    namespace, _, node_name = owner.rpartition("/")
    node = Node(session, 0, node_name, namespace or "/")
    token = DIALECT.token(Endpoint(kind, name, type_name, session, "RIHS01_0", Qos(), number, node))
    assert token is not None
    return token
