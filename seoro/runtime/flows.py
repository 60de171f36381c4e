"""Flows of control, what of them can be ended, and what they wait for: the data of the agenda.

A flow is a member of a `parallel` or `one_of`, or the run itself, and is one task. Its scopes are the behaviors in
it that are being carried out, each within the one before; other flows are forked from the innermost.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, TypeAlias

from seoro.runtime.past import Past

if TYPE_CHECKING:
    import asyncio

    from seoro.runtime.verdict import Outcome


Guard: TypeAlias = "Callable[[Flow, Callable[[], None]], None]"  # is given what lets the flow go on


class Scope:
    """A behavior that can be ended as a whole: the flow it runs in and everything forked from there.

    It is open in a `with` block, within those that are open already.

    Args:
        flow: The flow.
        depth: Its position among the scopes of the flow.
    """

    __slots__ = ("depth", "flow", "has_end", "outcome")

    def __init__(self, flow: Flow, depth: int) -> None:
        self.flow = flow
        self.depth = depth
        self.outcome: Outcome | None = None  # set when it is ended
        self.has_end = False  # whether it has an end of its own, whatever runs in it

    def __enter__(self) -> Scope:
        self.flow.scopes.append(self)
        return self

    def __exit__(self, *_: object) -> None:
        self.flow.scopes.pop()

    @property
    def around(self) -> Iterator[Scope]:
        """The scopes that it lies in, from the nearest."""
        scope: Scope | None = self
        while scope is not None:
            yield from reversed(scope.flow.scopes[: scope.depth])
            scope = scope.flow.parent
            if scope is not None:
                yield scope

    @property
    def flows(self) -> list[Flow]:
        """The flows that were forked in it, at any remove, and have not ended, in the order of their starts."""
        found: list[Flow] = []
        pending = [
            flow for flow in self.flow.forked if flow.parent is not None and flow.parent.depth >= self.depth
        ]
        while pending:
            flow = pending.pop()
            found.append(flow)
            pending.extend(flow.forked)
        found.sort(key=lambda flow: flow.started)
        return found


class Flow:
    """A flow of control.

    Args:
        path: Position in the tree of invocations; flows are stepped in its order.
        parent: The scope from which it was forked; None for the run itself.
        started: Its place in the order of starts: the round and the path; the order of steps does not matter.
    """

    __slots__ = (
        "alive",
        "asking",
        "delivered",
        "delivered_at",
        "ended",
        "foreign",
        "forked",
        "fresh",
        "guard",
        "on_cancel",
        "on_end",
        "open_ended",
        "outcome",
        "outside",
        "overran",
        "parent",
        "parked",
        "past",
        "path",
        "scopes",
        "started",
        "task",
        "told",
    )

    def __init__(self, path: tuple[int, ...], parent: Scope | None, started: tuple[int, tuple[int, ...]]) -> None:
        self.path = path
        self.parent = parent
        self.started = started
        self.task: asyncio.Task[None] | None = None  # once it has begun
        self.forked: dict[Flow, None] = {}  # the flows forked from it that have not ended, in order of starts
        self.on_end: Callable[[Flow], None] | None = None
        self.on_cancel: Callable[[], None] | None = None  # called when it is told that it is cancelled
        self.guard: Guard | None = None  # called when its next wait is over, between rounds
        self.scopes: list[Scope] = [Scope(self, 0)]
        self.outcome: Outcome | None = None
        self.alive = True
        self.ended: Scope | None = None  # the outermost scope that was ended and has not been left yet
        self.delivered = False  # whether the flow has been told so
        self.delivered_at = 0.0  # [s, monotonic]
        self.overran = False  # whether its clean-up since then has taken too long
        self.told = False  # whether the cancellation that it sees next comes from the agenda
        self.fresh = True  # freed for the first time: its first step is this one
        self.asking = False
        self.parked: asyncio.Future[Any] | None = None  # what it waits on here
        self.foreign: asyncio.Future[Any] | None = None  # what it waits on outside
        self.outside = False
        self.open_ended = False  # whether what it carries out has no end of its own
        self.past: Past = parent.flow.past.fork() if parent is not None else Past()


class Waiter:
    """A flow that waits for something that is fired, once, with a value."""

    __slots__ = ("fired", "flow", "over", "value")

    def __init__(self, flow: Flow) -> None:
        self.flow = flow
        self.fired = False
        self.value: Any = None
        self.over = False  # whether its flow waits no more
