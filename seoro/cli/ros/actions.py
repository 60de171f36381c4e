"""`seoro ros action`: actions of a system, and sending them goals."""

from __future__ import annotations

import argparse
import asyncio
import sys
from typing import Any

from seoro.bridges.ros2.clients.errors import GoalRejected
from seoro.bridges.ros2.clients.goals import Goal, pursuing
from seoro.bridges.ros2.participant import RosNode
from seoro.cli.exits import Exit
from seoro.cli.ros.reaching import only_type, reached
from seoro.cli.ros.values import as_json, as_yaml, print_types, read_value
from seoro.runtime.contracts import GoalStatus
from seoro.terminal_text import printable


async def list_actions(options: argparse.Namespace) -> int:
    """Print the actions with their types."""
    async with reached(options) as node:
        actions = node.graph.actions()
    print_types(actions, in_json=options.json)
    return Exit.PASSED


async def send(options: argparse.Namespace) -> int:
    """Send a goal, and print how it ends; a signal cancels it."""
    goal = read_value(options.value)
    async with reached(options) as node:
        action = node.resolve(options.name)
        known = node.graph.actions()
        type_name = only_type("action", action, options.type, known.get(action, ()), known)
        return await _pursue(options, node, action, type_name, goal)


async def _pursue(options: argparse.Namespace, node: RosNode, action: str, type_name: str, goal: Any) -> int:
    def tell(feedback: Any) -> None:
        if options.feedback:
            _print(options, "feedback", plain(feedback))

    def note(text: str) -> None:
        print(f"warning: {printable(text)}", file=sys.stderr)

    pursued: Goal | None = None
    try:
        async with pursuing(node, action, type_name, goal, tell, note) as pursued:
            if not options.json:
                print(f"{action} has accepted the goal", flush=True)
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
    """Print how a goal that a signal has ended did end; a goal that may go on has been warned of."""
    if goal is None:
        print("interrupted before the server had accepted the goal", file=sys.stderr)
    elif goal.end is not None:
        is_canceled = goal.end.status is GoalStatus.CANCELED
        how = "was canceled" if is_canceled else f"was not canceled: it had ended ({goal.end.status.value})"
        print(f"the goal {how}", file=sys.stderr)


def plain(value: Any) -> Any:
    """Members of a message as dictionaries and lists."""
    if isinstance(value, list):
        return [plain(each) for each in value]
    return {name: plain(each) for name, each in value.items()} if hasattr(value, "items") else value


def _print(options: argparse.Namespace, what: str, value: Any) -> None:
    if options.json:
        print(as_json({what: value}), flush=True)
    else:
        text = as_yaml(value, full=options.full)
        print(f"{what}\n" + "\n".join(f"  {line}" for line in text.splitlines()), flush=True)
