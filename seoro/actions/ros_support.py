"""Support for actions on a ROS 2 system: failures as messages, and values in and out."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, Final

from seoro.actions.reports import DONE
from seoro.actions.ros_messages import member_of, read_message
from seoro.actions.ros_structs import of_struct
from seoro.errors import ActionFailed, BackendError, BackendLost, UsageError, cause_of
from seoro.lang.plan import PrimitiveType
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.actions.pending import Pending
from seoro.runtime.contracts.ros2 import Members, ObservedSystem, Ros2System, RosMessage, RosSubscription
from seoro.runtime.functions.actions import RosText
from seoro.runtime.functions.fitting import scalar
from seoro.runtime.values.values import Struct, Variable

TOPIC: Final[Mapping[str, RosText]] = {"topic_name": "name", "topic_type": "msg"}
"""Parameters of actions on a topic, for `@action`."""


def system_of(ctx: ActionContext) -> Ros2System:
    """Return the ROS 2 system of a run, for actions that declare `Ros2System` at `@action`."""
    return ctx.anywhere(Ros2System)


def observed_system(ctx: ActionContext) -> ObservedSystem:
    """Return the ROS 2 system of a run, for actions that declare `ObservedSystem` at `@action`."""
    return ctx.anywhere(ObservedSystem)


@contextmanager
def as_action_failure(place: Path = Path(), named: Path = Path()) -> Iterator[None]:
    """Turn refusals and failures of a ROS 2 system within the block into failures of the action.

    Args:
        place: Path of an involved file.
        named: Path of that file for messages.
    """
    try:
        yield
    except BackendLost:
        raise
    except (UsageError, BackendError) as error:
        raise ActionFailed(_words(error).replace(str(place), str(named))) from error
    except ExceptionGroup as group:
        if (lost := group.subgroup(BackendLost)) is not None:
            raise cause_of(lost) from group
        failures, others = group.split((UsageError, BackendError))
        if failures is None or others is not None:
            raise
        raise ActionFailed(_words(cause_of(failures)).replace(str(place), str(named))) from group


@contextmanager
def log_missing(ctx: ActionContext, describe: Callable[[], str]) -> Iterator[None]:
    """Log the missing items, if any, when the action is cancelled within the block."""
    try:
        yield
    except asyncio.CancelledError:
        if what := describe():
            ctx.log(f"`{ctx.name}` ends without: {what}")
        raise


def _words(error: Exception) -> str:
    help_text = error.help if isinstance(error, UsageError) else ""
    return f"{error}; {help_text}" if help_text else str(error)


async def next_message(
    ctx: ActionContext, subscription: RosSubscription, limit: float | None = None
) -> RosMessage:
    """Wait for the next message of a subscription, while the time of the run goes on.

    The subscription itself wakes the action: a task in between would add two turns of the event loop between a
    message and its consequences.

    Args:
        ctx: Context of the action.
        subscription: The subscription.
        limit: Time limit [s of the machine's clock]; None for no limit.

    Raises:
        TimeoutError: No message within the limit.
        BackendLost: No message within the limit, and the connection to the system was interrupted.
    """
    loop = asyncio.get_running_loop()
    end, began = None if limit is None else loop.time() + limit, time.monotonic()
    while (message := subscription.receive_nowait()) is None:
        if end is not None and loop.time() >= end:
            if loss := observed_system(ctx).loss_since(began):
                raise BackendLost(loss)
            raise TimeoutError
        arrival = Pending()
        subscription.on_arrival(partial(arrival.settle, DONE))
        timer = None if end is None else loop.call_at(end, arrival.settle, DONE)
        try:
            await ctx.report(arrival)
        finally:
            if timer is not None:
                timer.cancel()
    return message


def to_members(value: object, what: str) -> Members:
    """Return the members of a message that a scenario gives as text or as a struct.

    Args:
        value: The text or the struct.
        what: Name of the message for errors.

    Raises:
        ActionFailed: The text is invalid.
    """
    found = of_struct(value) if isinstance(value, Struct) else read(str(value), what)
    if found is None or found == "":
        return {}
    if not isinstance(found, Mapping):
        raise ActionFailed(f"{what} needs members, as in `{{data: 1}}`; found `{value}`")
    return found


def read(text: str, what: str) -> Any:
    """Read a message in YAML or JSON.

    Args:
        text: The text.
        what: Name of the message for errors.

    Raises:
        ActionFailed: The text is invalid.
    """
    try:
        return read_message(text)
    except UsageError as error:
        raise ActionFailed(f"{what}: {error}") from error


def store(ctx: ActionContext, target: Variable[object], found: object, what: str) -> None:
    """Store a received value in a variable: in a `string` as text, in a `float` also integers.

    Args:
        ctx: Context of the action.
        target: The variable.
        found: The value.
        what: Name of the value for errors.

    Raises:
        ActionFailed: The type of the variable does not fit.
    """
    type_, value = target.type, None
    if isinstance(type_, PrimitiveType):
        value = as_text(found) if type_.name == "string" else scalar(found, type_)
    if value is None:
        type_name = getattr(type_, "name", "list")
        raise ActionFailed(
            f"cannot store {what}, `{shown(found)}`, in `{target.path}` of the type {type_name}; choose a member "
            "that fits, or a variable of the type `string`"
        )
    ctx.update(target, lambda before: value)


def as_text(found: object) -> str:
    """Return a string as it is, anything else as JSON."""
    return found if isinstance(found, str) else json.dumps(found, default=_plain)


def shown(found: object) -> str:
    """Return the text of a value, shortened for messages."""
    text = as_text(found)
    return text if len(text) <= 200 else f"{text[:197]}..."


def _plain(value: object) -> object:
    return dict(value) if isinstance(value, Mapping) else str(value)


def member(found: Members, path: str, what: str) -> Any:
    """Return a member of a received message; the whole message if the path is empty.

    Raises:
        ActionFailed: The member is missing.
    """
    try:
        return member_of(found, path)
    except UsageError as error:
        raise ActionFailed(f"{what}: {error}") from error
