"""Waiting for what a backend reports later, and calling it off when the action is cancelled."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Collection, Coroutine
from typing import Any, TypeVar

from seoro.errors import ActionFailed
from seoro.runtime.context import ActionContext, Pending
from seoro.runtime.contracts import GoalStatus, Report, Reporter
from seoro.runtime.values import Actor

T = TypeVar("T")
DONE = Report(GoalStatus.SUCCEEDED)


async def finish(
    ctx: ActionContext, start: Callable[[Reporter], Awaitable[str]], cancel: Callable[[str], Awaitable[None]]
) -> Report:
    """Start something at a backend and wait for its report, which is returned.

    Args:
        ctx: Of the action.
        start: Starts it, given whom to report to; returns its id.
        cancel: Calls it off by its id.

    Raises:
        ActionFailed: The backend reports that it did not succeed, with its reason.
    """
    pending = Pending()
    number = await ctx.ask(start(pending.settle))
    try:
        report = await ctx.report(pending)
    finally:
        if not pending.settled:
            await ctx.ask(cancel(number))
    return succeeded(report)


async def move(
    ctx: ActionContext,
    actor: Actor,
    start: Callable[[Reporter], Awaitable[str]],
    cancel: Callable[[str], Awaitable[None]],
    may_touch: Collection[str] | None,
) -> Report:
    """As `finish`, for what moves the robot of an actor; it fails, too, when that moves into something.

    Args:
        ctx: Of the action.
        actor: The actor.
        start: Starts the motion, given whom to report to; returns its id.
        cancel: Calls it off by its id.
        may_touch: Entities that the robot may touch, besides what modifiers allow; None for all.

    Raises:
        ActionFailed: The backend reports that the motion did not succeed, or the robot touched something else.
    """
    pending = Pending()
    struck: list[str] = []

    def touched(reason: str) -> None:
        if not pending.settled:
            struck.append(reason)
            pending.settle(Report(GoalStatus.ABORTED, reason))

    with ctx.guard(actor, may_touch, touched):
        number = await ctx.ask(start(lambda report: None if struck else pending.settle(report)))
        try:
            report = await ctx.report(pending)
        finally:
            if struck or not pending.settled:
                await ctx.ask(cancel(number))
    return succeeded(report)


def succeeded(report: Report) -> Report:
    """A report of a success.

    Raises:
        ActionFailed: It is none, with its reason.
    """
    if report.status is not GoalStatus.SUCCEEDED:
        raise ActionFailed(report.message or report.status.value)
    return report


async def meanwhile(ctx: ActionContext, work: Coroutine[Any, Any, T]) -> T:
    """Await something of the outside world that may last, while the time of the run goes on.

    Args:
        ctx: Of the action.
        work: What to await. If the action is cancelled, it is, and its clean-up is waited for.
    """
    pending = Pending()
    task = asyncio.ensure_future(work)
    task.add_done_callback(lambda done: pending.settle(DONE))
    try:
        await ctx.report(pending)
    except BaseException:
        task.cancel()
        await asyncio.wait({task})
        if not task.cancelled() and (error := task.exception()) is not None:
            raise error from None
        raise
    return task.result()
