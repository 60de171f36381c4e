"""Calls of the Python functions that implement actions."""

from __future__ import annotations

from collections.abc import Coroutine, Mapping
from typing import Any, cast

from seoro.runtime.actions.context import ActionContext
from seoro.runtime.functions.actions import BoundAction
from seoro.runtime.values.values import Actor, Value


def call_action(
    bound: BoundAction, context: ActionContext, actor: Actor | None, fields: Mapping[str, Value]
) -> Coroutine[Any, Any, None]:
    """Call the function of an action. Values refused by the types of the function are a fault of the function.

    Args:
        bound: The action.
        context: Context of the invocation.
        actor: Actor of the invocation, if it has one.
        fields: Values of the parameters; others are ignored.
    """
    converted = {name: convert(fields[name]) for name, convert in bound.converters.items()}
    leading = (actor,) if bound.declaration.has_actor else ()
    if bound.mark.thread:
        from seoro.runtime.actions.threads import run_in_thread  # noqa: PLC0415 - few actions have threads

        return run_in_thread(context, lambda inside: bound.function(inside, *leading, **converted))
    # It is `async`: checked when the scenario was loaded.
    return cast(Coroutine[Any, Any, None], bound.function(context, *leading, **converted))
