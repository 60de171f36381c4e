"""Ending behaviors in order: by scope, the last started flow first, each after the clean-up of the one before."""

from __future__ import annotations

import time
from collections.abc import Callable

from seoro.runtime.flows import Flow, Scope
from seoro.runtime.verdict import Outcome


def end(scope: Scope, outcome: Outcome, cancel: Callable[[Flow], None]) -> None:
    """End a scope, unless it has been left.

    Args:
        scope: What is ended.
        outcome: Its outcome from now on, unless it was ended before.
        cancel: Cancels a flow in the next round.
    """
    if scope not in scope.flow.scopes:
        return
    if scope.outcome is None:
        scope.outcome = outcome
    flows = scope.flows
    for flow in flows:
        _doom(flow, flow.scopes[0])
    _doom(scope.flow, scope)
    _cancel_in_turn([scope.flow, *flows], cancel)


def _doom(flow: Flow, scope: Scope) -> None:
    if flow.ended is None or scope.depth < flow.ended.depth:
        flow.ended = scope


def _cancel_in_turn(flows: list[Flow], cancel: Callable[[Flow], None]) -> None:
    """Cancel the last flow, and go on when it has ended; one that another end has cancelled is waited for."""
    while flows:
        flow = flows.pop()
        if not flow.alive or flow.ended is None:
            continue
        if flows:
            after = flow.on_end

            def ended(flow: Flow, after: Callable[[Flow], None] | None = after) -> None:
                if after is not None:
                    after(flow)
                _cancel_in_turn(flows, cancel)

            flow.on_end = ended
        if not flow.delivered:
            flow.delivered, flow.delivered_at, flow.overran = True, time.monotonic(), False
            cancel(flow)
        return
