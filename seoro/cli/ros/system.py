"""Connection of a command to a ROS 2 system, and lookup of its entities."""

from __future__ import annotations

import argparse
from collections.abc import AsyncIterator, Iterable, Sequence
from contextlib import asynccontextmanager

from seoro.bridges.ros2.clients.presence import full_name
from seoro.bridges.ros2.participant import RosNode, RosOptions, connect_system
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.errors import UsageError
from seoro.lang.diagnostics import near

NAME = "seoro_ros"  # node name of commands


@asynccontextmanager
async def connected(options: argparse.Namespace) -> AsyncIterator[RosNode]:
    """Connect to the system of the options as a node.

    Raises:
        UsageError, BackendError: The system is unreachable, or empty.
    """
    dialect = None if options.dialect == "auto" else options.dialect
    ros = RosOptions(options.ros, options.domain, dialect, options.interfaces, options.distribution)
    async with connect_system(ros) as system, system.node(NAME) as node:
        yield node


def lists_nodes(node: RosNode) -> bool:
    """Return whether the system announces its nodes; bridges for DDS do not."""
    return isinstance(node.graph.dialect, RmwZenoh)


def find_node(node: RosNode, name: str) -> str:
    """Return the full name of another node.

    Raises:
        UsageError: The node is unknown.
    """
    full = full_name(name)
    known = [each for each in node.graph.nodes() if each != node.node.full_name]
    if lists_nodes(node) and full not in known:
        raise UsageError(f"unknown node {full}", help=near(full, known) or f"nodes: {', '.join(known) or 'none'}")
    return full


def resolve_type(what: str, name: str, given: str | None, found: Sequence[str], known: Iterable[str]) -> str:
    """Return the type of a topic, service or action.

    Args:
        what: `topic`, `service` or `action`.
        name: Full name.
        given: Type on the command line, if any.
        found: Types in the system.
        known: Names of all topics, services or actions in the system.

    Raises:
        UsageError: No type is given, and the name is unknown or has several types.
    """
    if given is not None:
        return given
    match list(found):
        case [one]:
            return one
        case []:
            names = list(known)
            namesakes = [each for each in names if each.endswith(f"/{name.rpartition('/')[2]}")]
            raise UsageError(
                f"unknown {what} {name}",
                help=near(name, names)
                or f"{what}s: {', '.join(sorted(namesakes or names)) or 'none'}; to wait for it, give its type",
            )
        case more:
            raise UsageError(
                f"the {what} {name} has several types: {', '.join(more)}", help=f"give one of them after `{name}`"
            )
