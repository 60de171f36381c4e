"""`one_of` (7.3.13.3, 7.6.2.1): exactly one of the members.

Members that begin with a `wait` are guarded. Of the unguarded ones, one is drawn from the seed and invoked; beside
it the guards of all guarded members are armed. The first of these to happen decides, and everything else is
cancelled: the invoked member ends, or a guard is over and its member goes on. What happens in one instant has no
order: of guards that are over in it the first in the text wins, and a member that ends in it has ended first. So
a guard decides when nothing else is left to do in its instant. When the invoked member fails, the guarded ones
stay armed; if there are none, the next unguarded member is drawn. That an `override` ends the invoked member
decides, too; what it keeps from starting, or ends before its guard is over, is out.
"""

from __future__ import annotations

from collections.abc import Callable

from seoro.lang.plan import Behavior, OneOf, Serial, Wait
from seoro.runtime.agenda import Flow
from seoro.runtime.behaviors.members import Members, Perform, members_of
from seoro.runtime.place import Place
from seoro.runtime.timetable import Limit
from seoro.runtime.verdict import SUCCEEDED, Outcome, Status, failure


async def run_one_of(plan: OneOf, place: Place, perform: Perform) -> Outcome:
    """Carry it out."""
    choice = _Choice(plan, place)
    with members_of(place, perform, choice.member_ended) as members:
        choice.members = members
        for index, member in enumerate(plan.members):
            if _is_guarded(member):
                members.start(index, member, guard=choice.hold)
        await choice.run()
    await place.agenda.step(place.flow)
    return choice.outcome()


class _Choice:
    """Which member it is going to be."""

    members: Members

    def __init__(self, plan: OneOf, place: Place) -> None:
        self._plan = plan
        self._place = place
        self._decided: Flow | None = None
        self._held: dict[Flow, Callable[[], None]] = {}  # members whose guards are over, and what lets them go on
        self._is_choosing = False
        self._failures: list[Outcome] = []
        unguarded = [(i, member) for i, member in enumerate(plan.members) if not _is_guarded(member)]
        place.services.random(place.purpose).shuffle(unguarded)
        self._untried = unguarded

    async def run(self) -> None:
        """Start members as they are drawn, and wait for the ends of all that run."""
        while True:
            if self._untried:
                self.members.start(*self._untried.pop())
            await self.members.gather()
            if self._decided is not None or not self._untried:
                return

    def hold(self, flow: Flow, go_on: Callable[[], None]) -> None:
        """The guard of a member is over: it goes on if it is chosen at the end of this instant."""
        self._held[flow] = go_on
        if not self._is_choosing:
            self._is_choosing = True
            self._place.agenda.choose(Limit(self._place.flow.scopes[-1], self._choose))

    def _choose(self) -> None:
        self._is_choosing = False
        able = [flow for flow in self._held if flow.ended is None]
        if able and self._decided is None:
            first = min(able, key=lambda flow: flow.path)
            self._decide(first)
            self._held[first]()

    def _decide(self, flow: Flow) -> None:
        """This member it is: cancel the others."""
        self._decided = flow
        for other in self.members.alive:
            if other is not flow:
                self._place.agenda.end_flow(other, Outcome(Status.CANCELLED, "another member was chosen"))

    def member_ended(self, flow: Flow) -> None:
        """The invoked member has ended, or one that was chosen by its guard."""
        assert flow.outcome is not None
        if flow.outcome.failed:
            self._failures.append(flow.outcome)
        elif self._decided is None and (flow.outcome.status is Status.SUCCEEDED or self._was_invoked(flow)):
            self._decide(flow)

    def _was_invoked(self, flow: Flow) -> bool:
        """Whether a member went on, and did not only wait for its guard."""
        waited = flow.guard is not None or flow in self._held
        return not waited and flow.outcome is not None and flow.outcome.has_begun

    def outcome(self) -> Outcome:
        """That of the member that was chosen; a failure when every member has failed."""
        if self._decided is not None:
            assert self._decided.outcome is not None
            return self._decided.outcome
        if self._failures:
            last = self._failures[-1]
            reason = f"every member has failed, the last because: {last.reason}"
            return failure(reason, self._plan.span, last.explanation)
        return SUCCEEDED


def _is_guarded(member: Behavior) -> bool:
    """Whether a member begins with a `wait`, possibly inside of `serial`."""
    while isinstance(member, Serial) and member.members:
        member = member.members[0]
    return isinstance(member, Wait)
