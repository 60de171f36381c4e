"""`seoro ros service`: list and call services."""

from __future__ import annotations

import argparse

from seoro.bridges.ros2.descriptions import node_for_service
from seoro.cli.exit_status import Exit
from seoro.cli.ros.system import connected, resolve_type
from seoro.cli.ros.values import as_json, as_yaml, print_types, read_value


async def list_services(options: argparse.Namespace) -> int:
    """Print services with their types."""
    async with connected(options) as node:
        services = node.graph.services(hidden=options.all)
    print_types(services, in_json=options.json)
    return Exit.PASSED


async def call(options: argparse.Namespace) -> int:
    """Call a service and print its response."""
    request = read_value(options.value)
    async with connected(options) as node:
        service = node.resolve(options.name)
        known = node.graph.services(hidden=True)
        type_name = resolve_type("service", service, options.type, known.get(service, ()), known)
        caller = await node_for_service(node, service, type_name)
        async with caller.calling(service, type_name) as client:
            await client.wait_for_server(options.timeout)
            response = await client.call(request, options.timeout)
        value = caller.system.types.plain(f"{client.type}_Response", response)
    print(as_json(value) if options.json else as_yaml(value, full=options.full))
    return Exit.PASSED
