"""Waiting for reports of a backend, with cancellation of the work when the action is cancelled."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Collection
from contextlib import nullcontext
from typing import TypeVar

from seoro.errors import ActionFailed
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.actions.pending import Pending
from seoro.runtime.contracts.backends import GoalStatus, Report, Reporter
from seoro.runtime.values.values import Actor

T = TypeVar("T")
DONE = Report(GoalStatus.SUCCEEDED)


async def finish(
    ctx: ActionContext,
    start: Callable[[Reporter], Awaitable[str]],
    cancel: Callable[[str], Awaitable[None]],
    moved: Actor | None = None,
    may_touch: Collection[str] | None = (),
) -> Report:
    """Start work of a backend, wait for its report, and return that.

    Args:
        ctx: Context of the action.
        start: Starts the work, given a reporter; returns its id.
        cancel: Cancels the work by its id.
        moved: Actor whose robot the work moves, or None.
        may_touch: Entities that this robot may touch, in addition to modifiers; None for all.

    Raises:
        ActionFailed: The backend reports a failure, or the robot moved into something else.
    """
    pending = Pending()
    struck: list[str] = []

    def touched(reason: str) -> None:
        if not pending.settled:
            struck.append(reason)
            pending.settle(Report(GoalStatus.ABORTED, reason))

    with nullcontext() if moved is None else ctx.guard(moved, may_touch, touched):
        number = await ctx.ask(start(lambda report: None if struck else pending.settle(report)))
        try:
            report = await ctx.report(pending)
        finally:
            if struck or not pending.settled:
                await ctx.ask(cancel(number))
    if report.status is not GoalStatus.SUCCEEDED:
        raise ActionFailed(report.message or report.status.value)
    return report


async def meanwhile(ctx: ActionContext, work: Awaitable[T]) -> T:
    """Await external work of some length, while the time of the run goes on.

    Args:
        ctx: Context of the action.
        work: The work. If the action is cancelled, the work is cancelled and its clean-up is awaited.
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
