"""Waiting for what a backend reports later, and calling it off when the action is cancelled."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any, TypeVar

from seoro.errors import ActionFailed
from seoro.runtime.context import ActionContext, Pending
from seoro.runtime.contracts import GoalStatus, Report, Reporter

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
