"""Waiting for what a backend reports later, and calling it off when the action is cancelled."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from seoro.errors import ActionFailed
from seoro.runtime.context import ActionContext, Pending
from seoro.runtime.contracts import GoalStatus, Report, Reporter


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
