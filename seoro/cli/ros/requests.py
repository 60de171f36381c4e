"""`seoro ros service`, `action` and `param`: call services, send goals, get and set parameters."""

from __future__ import annotations

import argparse
import asyncio
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from seoro.bridges.ros2.clients.goals import Goal, sending_goal
from seoro.bridges.ros2.clients.parameters import get_parameters, list_parameters, set_parameter
from seoro.bridges.ros2.descriptions import node_for_service
from seoro.bridges.ros2.errors import GoalRejected, NodeRefused
from seoro.bridges.ros2.participant import RosNode
from seoro.cli.exit_status import Exit
from seoro.cli.ros.system import connected, find_node, resolve_type
from seoro.cli.ros.values import as_json, as_yaml, read_words
from seoro.errors import UsageError
from seoro.runtime.contracts.backends import GoalStatus
from seoro.text.printable import printable


async def call_service(options: argparse.Namespace) -> int:
    """Call a service and print its response."""
    given, request = read_words(options.words)
    async with connected(options) as node:
        service = node.resolve(options.name)
        known = node.graph.services(hidden=True)
        type_name = resolve_type("service", service, given, known.get(service, ()), known)
        caller = await node_for_service(node, service, type_name)
        async with caller.calling(service, type_name) as client:
            await client.wait_for_server(options.timeout)
            response = await client.call(request, options.timeout)
        value = caller.system.types.plain(f"{client.type}_Response", response)
    print(as_json(value) if options.json else as_yaml(value, full=options.full))
    return Exit.PASSED


async def send_goal(options: argparse.Namespace) -> int:
    """Send a goal and print its result; a signal cancels the goal."""
    given, goal = read_words(options.words)
    async with connected(options) as node:
        action = node.resolve(options.name)
        known = node.graph.actions()
        type_name = resolve_type("action", action, given, known.get(action, ()), known)
        return await _pursue(options, node, action, type_name, goal)


async def _pursue(options: argparse.Namespace, node: RosNode, action: str, type_name: str, goal: Any) -> int:
    def on_feedback(feedback: Any) -> None:
        if options.feedback:
            _print(options, "feedback", _plain(feedback))

    def warn(text: str) -> None:
        print(f"warning: {printable(text)}", file=sys.stderr)

    pursued: Goal | None = None
    try:
        async with sending_goal(node, action, type_name, goal, on_feedback, warn) as pursued:
            if not options.json:
                print(f"{action} accepted the goal", flush=True)
            ended = await pursued.ended()
    except GoalRejected as rejected:
        print(printable(str(rejected)))
        return Exit.FAILED
    except asyncio.CancelledError:
        _print_interrupted(pursued)
        raise
    _print(options, ended.status.value, _plain(ended.result))
    return Exit.PASSED if ended.status is GoalStatus.SUCCEEDED else Exit.FAILED


def _print_interrupted(goal: Goal | None) -> None:
    """Print the end of a goal that a signal interrupted; a warning was printed if it may continue."""
    if goal is None:
        print("interrupted before the server accepted the goal", file=sys.stderr)
    elif goal.end is not None:
        is_canceled = goal.end.status is GoalStatus.CANCELED
        how = "was canceled" if is_canceled else f"had already ended ({goal.end.status.value})"
        print(f"the goal {how}", file=sys.stderr)


def _plain(value: Any) -> Any:
    """Convert a message into dictionaries and lists."""
    if isinstance(value, list):
        return [_plain(each) for each in value]
    return {name: _plain(each) for name, each in value.items()} if hasattr(value, "items") else value


def _print(options: argparse.Namespace, what: str, value: Any) -> None:
    if options.json:
        print(as_json({what: value}), flush=True)
    else:
        text = as_yaml(value, full=options.full)
        print(f"{what}\n" + "\n".join(f"  {line}" for line in text.splitlines()), flush=True)


@contextmanager
def _node_errors() -> Iterator[None]:
    """Convert refusals of a node into usage errors."""
    try:
        yield
    except NodeRefused as error:
        raise UsageError(str(error)) from error


async def show_parameters(options: argparse.Namespace) -> int:
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


async def set_parameter_value(options: argparse.Namespace) -> int:
    """Set a parameter of a node."""
    async with connected(options) as node:
        other = find_node(node, options.node)
        with _node_errors():
            await set_parameter(node, other, options.name, options.value)
            values = await get_parameters(node, other, [options.name])
    print(f"{options.name} of {other} is now {as_yaml(values[options.name], full=True)}")
    return Exit.PASSED
