"""`seoro ros param`: parameters of nodes."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager

from seoro.bridges.ros2.clients.errors import NodeRefused
from seoro.bridges.ros2.clients.parameters import get_parameters, list_parameters, set_parameter
from seoro.cli.exits import Exit
from seoro.cli.ros.reaching import existing_node, reached
from seoro.cli.ros.values import as_json, as_yaml
from seoro.errors import InvalidUse


@contextmanager
def _refusing() -> Iterator[None]:
    """What a node refuses was asked for wrongly."""
    try:
        yield
    except NodeRefused as error:
        raise InvalidUse(str(error)) from error


async def show(options: argparse.Namespace) -> int:
    """Print parameters of a node, those that are named or all, with their values."""
    async with reached(options) as node:
        other = existing_node(node, options.node)
        with _refusing():
            names = options.names or await list_parameters(node, other)
            values = await get_parameters(node, other, names)
    if options.json:
        print(as_json(values))
    elif len(options.names) == 1:
        print(as_yaml(values[options.names[0]], full=True))
    elif values:
        print(as_yaml(values, full=options.full))
    return Exit.PASSED


async def change(options: argparse.Namespace) -> int:
    """Set a parameter of a node."""
    async with reached(options) as node:
        other = existing_node(node, options.node)
        with _refusing():
            await set_parameter(node, other, options.name, options.value)
            values = await get_parameters(node, other, [options.name])
    print(f"{options.name} of {other} is {as_yaml(values[options.name], full=True)}")
    return Exit.PASSED
