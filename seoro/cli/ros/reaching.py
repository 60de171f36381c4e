"""Reaching the system that a command is about, and finding things in it."""

from __future__ import annotations

import argparse
from collections.abc import AsyncIterator, Iterable, Sequence
from contextlib import asynccontextmanager

from seoro.bridges.ros2.clients.presence import full_name
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import RosNode, connect
from seoro.bridges.ros2.wire import Endpoint, RmwZenoh, named_dialect
from seoro.errors import InvalidUse
from seoro.lang.diagnostics import near

NAME = "seoro_ros"  # of the node that commands are


@asynccontextmanager
async def reached(options: argparse.Namespace) -> AsyncIterator[RosNode]:
    """Be a node of the system that the options say.

    Raises:
        InvalidUse, BackendError: It is not reached, or nothing is there.
    """
    types = TypeStore.bundled(options.distribution)
    for folder in options.interfaces:
        types = types.add_folder(folder)
    dialect = named_dialect(None if options.dialect == "auto" else options.dialect, options.domain)
    system = connect(options.ros, types=types, dialect=dialect, domain=options.domain)
    async with system as reaching, reaching.node(NAME) as node:
        yield node


def tells_nodes(node: RosNode) -> bool:
    """Whether the system says which nodes it has; bridges for DDS do not."""
    return isinstance(node.graph.dialect, RmwZenoh)


def existing_node(node: RosNode, name: str) -> str:
    """The full name of another node.

    Raises:
        InvalidUse: The system has no such node.
    """
    full = full_name(name)
    known = [each for each in node.graph.nodes() if each != node.node.full_name]
    if tells_nodes(node) and full not in known:
        raise InvalidUse(
            f"there is no node {full}", help=near(full, known) or f"nodes are {', '.join(known) or 'none'}"
        )
    return full


def of_others(node: RosNode, endpoints: Iterable[Endpoint]) -> tuple[Endpoint, ...]:
    """Those endpoints that are not the command's own."""
    return tuple(each for each in endpoints if each.session != node.node.session)


def only_type(what: str, name: str, given: str | None, found: Sequence[str], known: Iterable[str]) -> str:
    """The type of a topic, service or action.

    Args:
        what: `topic`, `service` or `action`.
        name: Its full name.
        given: The type that the command line says; None if it says none.
        found: The types that it has in the system.
        known: The names of all such things in the system.

    Raises:
        InvalidUse: It is not there, or not all agree on its type, and none was given.
    """
    if given is not None:
        return given
    match list(found):
        case [one]:
            return one
        case []:
            names = list(known)
            namesakes = [each for each in names if each.endswith(f"/{name.rpartition('/')[2]}")]
            raise InvalidUse(
                f"there is no {what} {name}",
                help=near(name, names)
                or f"there is {', '.join(sorted(namesakes or names)) or 'none'}; with `--type` it is waited for",
            )
        case more:
            raise InvalidUse(
                f"the {what} {name} has several types: {', '.join(more)}", help="say which with `--type`"
            )
