"""Actions of `osc.helpers`."""

from __future__ import annotations

from seoro.runtime.actions import action
from seoro.runtime.context import ActionContext


@action("log")
async def log(ctx: ActionContext, msg: object) -> None:
    """Write a message into the trace."""
    ctx.log(str(msg))
