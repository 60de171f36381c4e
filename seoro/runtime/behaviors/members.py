"""Members of `parallel` and `one_of`: a flow and a task for each, and the wait for their ends."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, Awaitable, Callable, Coroutine
from contextlib import asynccontextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, TypeAlias

import anyio
from anyio.abc import TaskGroup

from seoro.lang.plan import Behavior
from seoro.runtime.agenda import Agenda, Flow, Waiter
from seoro.runtime.invocation import Place
from seoro.runtime.verdict import Outcome, Status

Perform: TypeAlias = Callable[[Behavior, Place], Coroutine[Any, Any, Outcome]]
Carry: TypeAlias = Callable[[Place], Awaitable[Outcome]]  # a behavior that is known, at a place

_CANCELLED = Outcome(Status.CANCELLED)


async def carry_flow(agenda: Agenda, flow: Flow, behave: Callable[[], Awaitable[Outcome]]) -> None:
    """The whole life of a flow: what its task runs."""
    outcome = _CANCELLED
    try:
        await agenda.first_step(flow)
        outcome = await behave()
    except asyncio.CancelledError:
        if not agenda.left(flow.scopes[0]):
            raise
    finally:
        agenda.flow_ended(flow, outcome)


@dataclass(eq=False)
class Members:
    """The flows of a composition.

    Args:
        place: Of the composition.
        group: In which the members' tasks are.
        perform: Carries out a behavior.
        member_ended: Called between rounds when a member has ended.
    """

    place: Place
    group: TaskGroup
    perform: Perform
    member_ended: Callable[[Flow], None]
    flows: list[Flow] = field(default_factory=list)
    _waiter: Waiter | None = None

    @property
    def alive(self) -> list[Flow]:
        """The members that have not ended."""
        return [flow for flow in self.flows if flow.alive]

    def start(self, index: int, member: Behavior, guard: Callable[[Flow], None] | None = None) -> Flow:
        """Start a member; it takes its first step in the next round.

        Args:
            index: Its position in the composition.
            member: What it does.
            guard: Called between rounds when its first wait is over.
        """
        inside = self.place.member(index, member)
        flow = self.place.agenda.fork(inside.position, self.place.flow.scopes[-1])
        flow.on_end = self._ended
        flow.guard = guard
        self.flows.append(flow)
        behave = partial(self.perform, member, replace(inside, flow=flow))
        self.group.start_soon(carry_flow, self.place.agenda, flow, behave)
        return flow

    def _ended(self, flow: Flow) -> None:
        self.member_ended(flow)
        if not self.alive:
            self.wake()

    def end(self, flow: Flow, outcome: Outcome) -> None:
        """End a member with an outcome that is its own. To be called between rounds."""
        member = flow.scopes[1] if len(flow.scopes) > 1 else flow.scopes[0]
        self.place.agenda.end(member, outcome)

    def wake(self) -> None:
        """Let the composition go on from `wait`."""
        if self._waiter is not None:
            self.place.agenda.fire(self._waiter)

    async def wait(self, until: float | None = None) -> None:
        """Wait until the composition is woken, as it is when the last member has ended.

        Args:
            until: When to wait no longer [s].
        """
        self._waiter = Waiter(self.place.flow)
        if until is not None:
            self.place.agenda.fire_at(until, self._waiter)
        await self.place.agenda.wait(self._waiter)

    async def gather(self) -> None:
        """Wait until all members have ended, also when the composition itself is cancelled meanwhile.

        Raises:
            asyncio.CancelledError: It was cancelled; all members have ended.
        """
        cancelled: asyncio.CancelledError | None = None
        while self.alive:
            try:
                await self.wait()
            except asyncio.CancelledError as error:
                cancelled = error
        if cancelled is not None:
            raise cancelled

    def inherit_pasts(self) -> None:
        """What members emitted and consumed in this instant is in the past of who joins them."""
        for member in self.flows:
            self.place.flow.past.join(member.past, self.place.agenda.instant)


@asynccontextmanager
async def member_group(
    place: Place, perform: Perform, member_ended: Callable[[Flow], None]
) -> AsyncGenerator[Members]:
    """The members of a composition, in a task group; at its end, their past is the composition's.

    Args:
        place: Of the composition.
        perform: Carries out a behavior.
        member_ended: Called between rounds when a member has ended.
    """
    cancelled: asyncio.CancelledError | None = None
    async with anyio.create_task_group() as group:
        members = Members(place, group, perform, member_ended)
        try:
            yield members
        except asyncio.CancelledError as error:
            cancelled = error  # passed on outside of the task group, which would take it for its own
    members.inherit_pasts()
    if cancelled is not None:
        raise cancelled
