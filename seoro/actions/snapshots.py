"""Actions of `osc.snapshots`: saving and restoring the whole simulation."""

from __future__ import annotations

from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.worlds import Snapshots
from seoro.runtime.functions.actions import action


@action("save_snapshot", anywhere=Snapshots)
async def save_snapshot(ctx: ActionContext, name: str) -> None:
    """Save the simulation under a name."""
    await ctx.ask(ctx.anywhere(Snapshots).save_snapshot(name))


@action("restore_snapshot", anywhere=Snapshots)
async def restore_snapshot(ctx: ActionContext, name: str, seed: int) -> None:
    """Restore the simulation that was saved under a name."""
    await ctx.ask(ctx.anywhere(Snapshots).restore_snapshot(name, seed if seed >= 0 else None))
