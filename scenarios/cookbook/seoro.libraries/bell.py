"""Actions of `bell.osc`."""

from seoro import ActionContext, ActionFailed, Actor, Variable, action


class Rings(dict[str, int]):
    """Numbers of rings of each bell in a run."""


@action("bell.ring")
async def ring(ctx: ActionContext, bell: Actor, times: int) -> None:
    """Ring several times, a second apart."""
    if times > 5:
        raise ActionFailed(f"{times} rings break the bell; expected at most 5")
    rings = ctx.shared(Rings)
    for _ in range(times):
        ctx.log("ring")
        rings[bell.name] = rings.get(bell.name, 0) + 1
        await ctx.sleep(1.0)


@action("bell.count_rings")
async def count_rings(ctx: ActionContext, bell: Actor, target_variable: Variable[int]) -> None:
    """Store how often the bell has rung."""
    ctx.update(target_variable, lambda _: ctx.shared(Rings).get(bell.name, 0))
