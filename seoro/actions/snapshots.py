"""Actions of `osc.snapshots`: the whole simulation, saved and gone back to."""

from __future__ import annotations

from seoro.runtime.actions import action
from seoro.runtime.capabilities import Snapshots
from seoro.runtime.context import ActionContext


@action("save_snapshot", anywhere=Snapshots)
async def save_snapshot(ctx: ActionContext, name: str) -> None:
    """Save the simulation under a name."""
    await ctx.ask(ctx.anywhere(Snapshots).save_snapshot(name))


@action("restore_snapshot", anywhere=Snapshots)
async def restore_snapshot(ctx: ActionContext, name: str, seed: int) -> None:
    """Go back to what was saved under a name."""
    await ctx.ask(ctx.anywhere(Snapshots).restore_snapshot(name, seed if seed >= 0 else None))
