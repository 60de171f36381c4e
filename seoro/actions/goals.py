"""Goals of robots: awaited, or left active until the next goal replaces them."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Collection

from seoro.actions.reports import finish
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.backends import Reporter
from seoro.runtime.values.values import Actor


class _ActiveGoals:
    """Goals of a run that no action waits for, by actor and part."""

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
    """Send a goal to a robot, cancelling a previous unawaited goal, and wait for its end.

    Args:
        ctx: Context of the action.
        actor: The robot.
        part: The part of the robot in use, as in `uses` of the action.
        start: Starts the goal, given a reporter; returns its id.
        cancel: Cancels a goal by its id; goals that have ended are ignored.
        may_touch: Entities that the robot may touch, in addition to modifiers; None for all.
        success_on_acceptance: Whether to return once the goal is accepted. It ends with the run at the latest.

    Raises:
        ActionFailed: The goal failed, or the robot moved into something.
    """
    active = ctx.shared(_ActiveGoals).goals
    if (earlier := active.pop((actor.name, part), None)) is not None:
        await ctx.ask(cancel(earlier))
    if success_on_acceptance:
        active[actor.name, part] = await ctx.ask(start(_ignore))
    else:
        await finish(ctx, start, cancel, actor, may_touch)


def _ignore(_report: object) -> None:
    """Ignore the end of an unawaited goal."""
