"""Goals of robots: waited for, or left to go on until the next takes their place."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Collection

from seoro.actions.reports import move
from seoro.runtime.context import ActionContext
from seoro.runtime.contracts import Reporter
from seoro.runtime.values import Actor


class _Left:
    """The goals of a run that nobody waits for, by the actor and what of it is at work."""

    def __init__(self) -> None:
        self.goals: dict[tuple[str, str], str] = {}


async def pursue(
    ctx: ActionContext,
    actor: Actor,
    part: str,
    start: Callable[[Reporter], Awaitable[str]],
    cancel: Callable[[str], Awaitable[None]],
    *,
    may_touch: Collection[str] | None = (),
    success_on_acceptance: bool = False,
) -> None:
    """Give a robot a goal, in place of one that nobody waits for, and wait for its end.

    Args:
        ctx: Of the action.
        actor: The robot.
        part: What of it is at work, as `uses` of the action says.
        start: Starts it, given whom to report to; returns its id.
        cancel: Calls a goal off by its id; one that has ended is left alone.
        may_touch: Entities that the robot may touch, besides what modifiers allow; None for all.
        success_on_acceptance: Whether to leave it to itself once it is accepted. It ends with the run at last.

    Raises:
        ActionFailed: The goal is not reached, with the reason, or the robot has moved into something.
    """
    left = ctx.shared(_Left).goals
    if (earlier := left.pop((actor.name, part), None)) is not None:
        await ctx.ask(cancel(earlier))
    if success_on_acceptance:
        left[actor.name, part] = await ctx.ask(start(_ignore))
    else:
        await move(ctx, actor, start, cancel, may_touch)


def _ignore(_report: object) -> None:
    """Nobody waits for the end."""
