"""What actions on a ROS 2 system have in common: failures in words, and values in and out."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

from seoro.actions.reports import DONE
from seoro.actions.ros_messages import member_of, read_message
from seoro.actions.ros_structs import of_struct
from seoro.errors import ActionFailed, BackendError, BackendLost, InvalidUse
from seoro.lang.plan import PrimitiveType
from seoro.runtime.context import ActionContext, Pending
from seoro.runtime.ros_system import Members, Ros2System, RosMessage, RosSubscription
from seoro.runtime.values import INTEGER_LIMITS, Struct, Variable

Target: TypeAlias = Variable[object] | str  # a variable, or what is declared in the place of none


def system_of(ctx: ActionContext) -> Ros2System:
    """The ROS 2 system of a run; for actions that said at `@action` that they need it."""
    return ctx.anywhere(Ros2System)


@contextmanager
def failing(place: Path = Path(), named: Path = Path()) -> Iterator[None]:
    """In the block, what a ROS 2 system does not allow for or does not do is a failure of the action.

    Args:
        place: Of a file that may be wrong.
        named: How that is called for those who named it.
    """
    try:
        yield
    except BackendLost:
        raise
    except (InvalidUse, BackendError) as error:
        raise ActionFailed(_words(error).replace(str(place), str(named))) from error
    except ExceptionGroup as group:
        if (lost := group.subgroup(BackendLost)) is not None:
            raise _first(lost) from group
        told, others = group.split((InvalidUse, BackendError))
        if told is None or others is not None:
            raise
        raise ActionFailed(_words(_first(told)).replace(str(place), str(named))) from group


def _first(error: Exception) -> Exception:
    """First exception in a group, of any depth."""
    return _first(error.exceptions[0]) if isinstance(error, ExceptionGroup) else error


@contextmanager
def telling(ctx: ActionContext, without: Callable[[], str]) -> Iterator[None]:
    """In the block, an action that is ended from outside says what has not come by then, if anything."""
    try:
        yield
    except asyncio.CancelledError:
        if what := without():
            ctx.log(f"`{ctx.name}` ends without: {what}")
        raise


def _words(error: Exception) -> str:
    help_text = error.help if isinstance(error, InvalidUse) else ""
    return f"{error}; {help_text}" if help_text else str(error)


async def next_message(
    ctx: ActionContext, subscription: RosSubscription, limit: float | None = None
) -> RosMessage:
    """The next message of a subscription; waits for it while the time of the run goes on.

    The subscription itself wakes the action: a task that waits for it in between would be two more turns of the
    event loop from the message to what follows from it.

    Args:
        ctx: Of the action.
        subscription: The subscription.
        limit: How long to wait [s of the machine's clock]; without end when None.

    Raises:
        TimeoutError: None has come by then.
        BackendLost: None has come by then, and the connection to the system was lost meanwhile.
    """
    loop = asyncio.get_running_loop()
    end, began = None if limit is None else loop.time() + limit, time.monotonic()
    while (message := subscription.take_now()) is None:
        if end is not None and loop.time() >= end:
            if loss := system_of(ctx).loss_since(began):
                raise BackendLost(loss)
            raise TimeoutError
        arrival = Pending()
        subscription.when_arrived(partial(arrival.settle, DONE))
        timer = None if end is None else loop.call_at(end, arrival.settle, DONE)
        try:
            await ctx.report(arrival)
        finally:
            if timer is not None:
                timer.cancel()
    return message


def to_members(value: object, what: str) -> Members:
    """What a scenario gives for a message: a text, or a struct.

    Args:
        value: It.
        what: What it is for, for messages.

    Raises:
        ActionFailed: It is none.
    """
    found = of_struct(value) if isinstance(value, Struct) else _read(str(value), what)
    if found is None or found == "":
        return {}
    if not isinstance(found, Mapping):
        raise ActionFailed(f"{what} has members, as in `{{data: 1}}`; `{value}` has none")
    return found


def _read(text: str, what: str) -> Any:
    try:
        return read_message(text)
    except InvalidUse as error:
        raise ActionFailed(f"{what}: {error}") from error


def store(ctx: ActionContext, target: Target, found: object, what: str) -> None:
    """Let a variable hold something that has come.

    Args:
        ctx: Of the action.
        target: The variable; nothing is done if there is none.
        found: The value.
        what: What it is, for messages.

    Raises:
        ActionFailed: A variable of this type cannot hold it.
    """
    if isinstance(target, Variable):
        value = fitted(found, target, what)
        ctx.update(target, lambda before: value)


def fitted(found: object, variable: Variable[object], what: str) -> object:
    """A value as a variable holds it: what is no text becomes JSON in a `string`, a whole number a `float`."""
    match variable.type:
        case PrimitiveType("string"):
            return as_text(found)
        case PrimitiveType("bool") if isinstance(found, bool):
            return found
        case PrimitiveType("float") if isinstance(found, int | float) and not isinstance(found, bool):
            return float(found)
        case PrimitiveType("int" | "uint" as name) if isinstance(found, int) and not isinstance(found, bool):
            low, high = INTEGER_LIMITS[name]
            if low <= found <= high:
                return found
        case _:
            pass
    type_name = getattr(variable.type, "name", "list")
    raise ActionFailed(
        f"`{variable.path}` cannot hold {what}, which is `{shown(found)}`: it is a {type_name}; name a member "
        "that fits, or take a variable of the type `string`"
    )


def as_text(found: object) -> str:
    """A text as it is, anything else as JSON."""
    return found if isinstance(found, str) else json.dumps(found, default=_plain)


def shown(found: object) -> str:
    """The same, short enough for messages."""
    text = as_text(found)
    return text if len(text) <= 200 else f"{text[:197]}..."


def _plain(value: object) -> object:
    return dict(value) if isinstance(value, Mapping) else str(value)


def member(found: Members, path: str, what: str) -> Any:
    """A member of what has come; all of it if the path is empty.

    Raises:
        ActionFailed: There is none of that name.
    """
    try:
        return member_of(found, path)
    except InvalidUse as error:
        raise ActionFailed(f"{what}: {error}") from error
