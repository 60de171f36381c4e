"""`seoro ros action`: list actions and send goals."""

from __future__ import annotations

import argparse
import asyncio
import sys
from typing import Any

from seoro.bridges.ros2.clients.goals import Goal, sending_goal
from seoro.bridges.ros2.errors import GoalRejected
from seoro.bridges.ros2.participant import RosNode
from seoro.cli.exit_status import Exit
from seoro.cli.ros.system import connected, resolve_type
from seoro.cli.ros.values import as_json, as_yaml, print_types, read_value
from seoro.runtime.contracts.backends import GoalStatus
from seoro.text.printable import printable


async def list_actions(options: argparse.Namespace) -> int:
    """Print actions with their types."""
    async with connected(options) as node:
        actions = node.graph.actions()
    print_types(actions, in_json=options.json)
    return Exit.PASSED


async def send(options: argparse.Namespace) -> int:
    """Send a goal and print its result; a signal cancels the goal."""
    goal = read_value(options.value)
    async with connected(options) as node:
        action = node.resolve(options.name)
        known = node.graph.actions()
        type_name = resolve_type("action", action, options.type, known.get(action, ()), known)
        return await _pursue(options, node, action, type_name, goal)


async def _pursue(options: argparse.Namespace, node: RosNode, action: str, type_name: str, goal: Any) -> int:
    def on_feedback(feedback: Any) -> None:
        if options.feedback:
            _print(options, "feedback", plain(feedback))

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
    _print(options, ended.status.value, plain(ended.result))
    return Exit.PASSED if ended.status is GoalStatus.SUCCEEDED else Exit.FAILED


def _print_interrupted(goal: Goal | None) -> None:
    """Print the end of a goal that a signal interrupted; a warning was printed if it may continue."""
    if goal is None:
        print("interrupted before the server accepted the goal", file=sys.stderr)
    elif goal.end is not None:
        is_canceled = goal.end.status is GoalStatus.CANCELED
        how = "was canceled" if is_canceled else f"had already ended ({goal.end.status.value})"
        print(f"the goal {how}", file=sys.stderr)


def plain(value: Any) -> Any:
    """Convert a message into dictionaries and lists."""
    if isinstance(value, list):
        return [plain(each) for each in value]
    return {name: plain(each) for name, each in value.items()} if hasattr(value, "items") else value


def _print(options: argparse.Namespace, what: str, value: Any) -> None:
    if options.json:
        print(as_json({what: value}), flush=True)
    else:
        text = as_yaml(value, full=options.full)
        print(f"{what}\n" + "\n".join(f"  {line}" for line in text.splitlines()), flush=True)
