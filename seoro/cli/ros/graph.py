"""`seoro ros graph`: list the entities of a system or of one node."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from typing import Any, Final

from seoro.bridges.ros2.clients.lifecycle import lifecycle_state
from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.wire import Endpoint, Kind
from seoro.cli.exit_status import Exit
from seoro.cli.ros.system import connected, find_node, lists_nodes
from seoro.cli.ros.values import as_json, count_of
from seoro.cli.tables import table
from seoro.errors import UsageError

VERBS: Final = {
    Kind.PUBLISHER: "publishes",
    Kind.SUBSCRIPTION: "subscribes",
    Kind.SERVER: "serves",
    Kind.CLIENT: "calls",
}


async def show(options: argparse.Namespace) -> int:
    """Print the entities of the system, or of the given node."""
    async with connected(options) as node:
        what = _system(node, hidden=options.all) if options.node is None else await _node(node, options.node)
        if options.json:
            print(as_json(what))
        elif options.node is None:
            _print_system(node, what)
        else:
            _print_node(what)
        for name, types in _type_conflicts(node.graph).items():
            print(f"warning: {name} has conflicting types: {', '.join(types)}", file=sys.stderr)
    return Exit.PASSED


async def list_types(options: argparse.Namespace) -> int:
    """Print the topics, services or actions with their types."""
    async with connected(options) as node:
        match options.listed:
            case "topics":
                found = node.graph.topics(hidden=options.all)
            case "services":
                found = node.graph.services(hidden=options.all)
            case _:
                found = node.graph.actions()
    if options.json:
        print(as_json(found))
    elif found:
        print(table([[name, ", ".join(types)] for name, types in found.items()]))
    return Exit.PASSED


def _system(node: RosNode, *, hidden: bool) -> dict[str, Any]:
    graph = node.graph
    own = node.node.full_name
    return {
        "dialect": graph.dialect.name,
        "nodes": [name for name in graph.nodes() if name != own],
        "topics": [
            {
                "name": name,
                "types": list(types),
                "publishers": len(node.others(graph.publishers(name))),
                "subscriptions": len(node.others(graph.subscriptions(name))),
            }
            for name, types in graph.topics(hidden=hidden).items()
        ],
        "services": [
            {"name": name, "types": list(types)} for name, types in graph.services(hidden=hidden).items()
        ],
        "actions": [{"name": name, "types": list(types)} for name, types in graph.actions().items()],
    }


def _type_conflicts(graph: RosGraph) -> dict[str, tuple[str, ...]]:
    """Return topics and services with several types, whose endpoints do not match."""
    named = {**graph.topics(hidden=True), **graph.services(hidden=True)}
    return {name: types for name, types in named.items() if len(types) > 1}


def _print_system(node: RosNode, what: dict[str, Any]) -> None:
    print(f"dialect: {what['dialect']}")
    if what["nodes"] or lists_nodes(node):
        _print_part("nodes", [[name] for name in what["nodes"]])
    topics = [
        [
            each["name"],
            ", ".join(each["types"]),
            count_of(each["publishers"], "publisher"),
            count_of(each["subscriptions"], "subscription"),
        ]
        for each in what["topics"]
    ]
    _print_part("topics", topics)
    for part in ("services", "actions"):
        _print_part(part, [[each["name"], ", ".join(each["types"])] for each in what[part]])


def _print_part(name: str, rows: list[list[str]]) -> None:
    print(f"{name} ({len(rows)})")
    if rows:
        print(table(rows, "  "))


async def _node(node: RosNode, name: str) -> dict[str, Any]:
    if not lists_nodes(node):
        raise UsageError("bridges for DDS do not list nodes", help="leave out `--node`")
    full = find_node(node, name)
    endpoints = [each for each in node.graph.endpoints() if each.node is not None and each.node.full_name == full]
    found: dict[str, Any] = {"name": full}
    served = {each.name for each in endpoints if each.kind is Kind.SERVER}
    if f"{full}/get_state" in served:
        found["lifecycle_state"] = await lifecycle_state(node, full)
    for kind, verb in VERBS.items():
        found[verb] = _named(each for each in endpoints if each.kind is kind)
    return found


def _named(endpoints: Iterable[Endpoint]) -> list[dict[str, str]]:
    pairs = sorted({(each.name, each.type) for each in endpoints})
    return [{"name": name, "type": kind} for name, kind in pairs]


def _print_node(what: dict[str, Any]) -> None:
    print(what["name"])
    if "lifecycle_state" in what:
        print(f"lifecycle state: {what['lifecycle_state']}")
    for verb in VERBS.values():
        _print_part(verb, [[each["name"], each["type"]] for each in what[verb]])
