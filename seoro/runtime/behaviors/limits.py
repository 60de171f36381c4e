"""Limits of time on what is carried out, and behaviors without an end of their own.

A limit acts when the instant has otherwise settled: what ends by itself in that very instant is in time. What is
open-ended (an action whose implementation says so, a modifier that holds) is at home in what ends it.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterator
from functools import partial

from seoro.runtime.agenda import Agenda, Flow, Limit, Scope
from seoro.runtime.explain import explained
from seoro.runtime.place import Place
from seoro.runtime.verdict import Outcome, Status

_CUT_OFF = Outcome(Status.CANCELLED, "it came to its limit")


async def within_limit(
    place: Place,
    limit: float,
    behave: Callable[[], Awaitable[Outcome]],
    judge: Callable[[Scope], Outcome] = lambda scope: _CUT_OFF,
    has_end: bool = False,
) -> tuple[Outcome, bool]:
    """Carry something out, and end it when it still runs after a time.

    Args:
        place: Where it is carried out.
        limit: After what time it ends [s].
        behave: Carries it out.
        judge: The outcome of what comes to its limit, from the scope that still runs then.
        has_end: Whether the limit is an end that was asked for.

    Returns:
        The outcome, and whether it came to its limit.
    """
    agenda, flow = place.agenda, place.flow
    with agenda.scope(flow) as scope:
        scope.has_end = has_end
        reached = Limit(scope, lambda: agenda.end(scope, _explained(judge(scope), place, scope)))
        agenda.at(agenda.now + limit, reached)
        try:
            return await behave(), False
        except asyncio.CancelledError:
            if not agenda.left(scope):
                raise
            assert scope.outcome is not None, "it was ended"
            return scope.outcome, True
        finally:
            reached.over = True


def _explained(outcome: Outcome, place: Place, scope: Scope) -> Outcome:
    """What is asked for why something came to its limit; that it has succeeded needs no explanation."""
    return outcome if outcome.status is Status.SUCCEEDED else explained(outcome, place, scope)


def is_open_ended(agenda: Agenda, scope: Scope) -> bool:
    """Whether something that still runs in a scope has no end of its own."""
    return any(map(partial(_is_endless, scope), _running(agenda, scope)))


def is_all_open_ended(agenda: Agenda, scope: Scope) -> bool:
    """Whether nothing that still runs in a scope has an end of its own."""
    return all(map(partial(_is_endless, scope), _running(agenda, scope)))


def _running(agenda: Agenda, scope: Scope) -> Iterator[Flow]:
    """The flows in a scope that do not wait for flows that they forked."""
    flows = [scope.flow, *scope.flows]
    forked_from = {flow.parent.flow for flow in flows[1:] if flow.parent is not None}
    return (flow for flow in flows if flow not in forked_from)


def _is_endless(outermost: Scope, flow: Flow) -> bool:
    """Whether what a flow carries out is open-ended, and nothing around it in a scope is going to end it."""
    if not flow.open_ended:
        return False
    innermost = flow.scopes[-1]
    for scope in (innermost, *innermost.around):
        if scope is outermost:
            break
        if scope.has_end:
            return False
    return True
