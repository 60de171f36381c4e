"""The action `log` of `osc.helpers`, in a module of its own so that short scenarios load less."""

from __future__ import annotations

from typing import Any

from seoro.runtime.actions.context import ActionContext
from seoro.runtime.functions.actions import action


@action("log")
async def log(ctx: ActionContext, msg: Any) -> None:
    """Write a message into the trace; other values than strings are written as in the language."""
    ctx.log(ctx.text_of("msg", msg))
