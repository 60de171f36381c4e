"""`seoro ros param`: get and set parameters of nodes."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager

from seoro.bridges.ros2.clients.parameters import get_parameters, list_parameters, set_parameter
from seoro.bridges.ros2.errors import NodeRefused
from seoro.cli.exit_status import Exit
from seoro.cli.ros.system import connected, find_node
from seoro.cli.ros.values import as_json, as_yaml
from seoro.errors import UsageError


@contextmanager
def _node_errors() -> Iterator[None]:
    """Convert refusals of a node into usage errors."""
    try:
        yield
    except NodeRefused as error:
        raise UsageError(str(error)) from error


async def show(options: argparse.Namespace) -> int:
    """Print all or the named parameters of a node with their values."""
    async with connected(options) as node:
        other = find_node(node, options.node)
        with _node_errors():
            names = options.names or await list_parameters(node, other)
            values = await get_parameters(node, other, names)
    if options.json:
        print(as_json(values))
    elif len(options.names) == 1:
        print(as_yaml(values[options.names[0]], full=True))
    elif values:
        print(as_yaml(values, full=options.full))
    return Exit.PASSED


async def set_value(options: argparse.Namespace) -> int:
    """Set a parameter of a node."""
    async with connected(options) as node:
        other = find_node(node, options.node)
        with _node_errors():
            await set_parameter(node, other, options.name, options.value)
            values = await get_parameters(node, other, [options.name])
    print(f"{options.name} of {other} is now {as_yaml(values[options.name], full=True)}")
    return Exit.PASSED
