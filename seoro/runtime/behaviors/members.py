"""Members of `parallel` and `one_of`: a flow for each, and the wait for their ends."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TypeAlias

from seoro.lang.plan import Behavior
from seoro.runtime.agenda import Flow, Waiter
from seoro.runtime.flows import Guard
from seoro.runtime.place import Place
from seoro.runtime.verdict import Outcome

Perform: TypeAlias = Callable[[Behavior, Place], Awaitable[Outcome]]
Carry: TypeAlias = Callable[[Place], Awaitable[Outcome]]  # a behavior that is known, at a place


@dataclass(eq=False)
class Members:
    """The flows of a composition.

    Args:
        place: Of the composition.
        perform: Carries out a behavior.
        member_ended: Called between rounds when a member has ended.
    """

    place: Place
    perform: Perform
    member_ended: Callable[[Flow], None]
    flows: list[Flow] = field(default_factory=list)
    _waiter: Waiter | None = None
    _oldest: int = 0  # of those that may be alive

    @property
    def alive(self) -> list[Flow]:
        """The members that have not ended."""
        return [flow for flow in self.flows if flow.alive]

    @property
    def have_ended(self) -> bool:
        """Whether all of them have ended."""
        while self._oldest < len(self.flows) and not self.flows[self._oldest].alive:
            self._oldest += 1
        return self._oldest == len(self.flows)

    def start(self, index: int, member: Behavior, guard: Guard | None = None) -> Flow:
        """Start a member; it takes its first step in the next round.

        Args:
            index: Its position in the composition.
            member: What it does.
            guard: Called between rounds when its first wait is over; the member goes on when it is let.
        """
        inside = self.place.member(index, member)

        async def behave(flow: Flow) -> Outcome:
            return await self.perform(member, inside.within(flow))

        flow = self.place.agenda.fork(inside.position, self.place.flow.scopes[-1], behave)
        flow.on_end = self._ended
        flow.guard = guard
        self.flows.append(flow)
        return flow

    def _ended(self, flow: Flow) -> None:
        self.member_ended(flow)
        if self.have_ended:
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
            self.place.agenda.at(until, self._waiter)
        await self.place.agenda.wait(self._waiter)

    async def gather(self) -> None:
        """Wait until all members have ended, also when the composition itself is cancelled meanwhile.

        Raises:
            asyncio.CancelledError: It was cancelled; all members have ended.
        """
        cancelled: asyncio.CancelledError | None = None
        while not self.have_ended:
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


@contextmanager
def members_of(place: Place, perform: Perform, member_ended: Callable[[Flow], None]) -> Generator[Members]:
    """The members of a composition, all of which have ended when the block does; their past is the composition's.

    Args:
        place: Of the composition.
        perform: Carries out a behavior.
        member_ended: Called between rounds when a member has ended.
    """
    members = Members(place, perform, member_ended)
    try:
        yield members
    finally:
        members.inherit_pasts()
