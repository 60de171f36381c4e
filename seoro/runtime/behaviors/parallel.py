"""`parallel` (7.3.13.2, 7.6.2.1.4): members that overlap.

It ends when all members have ended. It fails with the first failing member, and the others are cancelled then;
of members that fail in one round, the first in the text counts. It fails, too, when members do not lie to the
primary one as its arguments say, or when there is no instant in which all of them run.

Where secondary members have to end with the primary one, or a while after it, those that still run then are
ended: that is what open-ended ones wait for; others are late, and the composition fails. All this is judged when
the instant has otherwise settled.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import groupby
from math import inf

from seoro.lang.plan import Parallel
from seoro.runtime.agenda import TIME_DIGITS, Flow, Limit, Scope
from seoro.runtime.behaviors.limits import is_open_ended
from seoro.runtime.behaviors.members import Members, Perform, members_of
from seoro.runtime.behaviors.overlap import Timing
from seoro.runtime.explain import explained
from seoro.runtime.place import Place, name_of
from seoro.runtime.verdict import SUCCEEDED, Outcome, Status, failure


async def run_parallel(plan: Parallel, timing: Timing, place: Place, perform: Perform) -> Outcome:
    """Carry it out."""
    course = _Course(plan, place, timing)
    with members_of(place, perform, course.member_ended) as members:
        course.members = members
        try:
            await course.run()
        finally:
            course.forget_limits()
    await place.agenda.step(place.flow)
    return course.outcome


class _Course:
    """The members as they start and end.

    Args:
        plan: The composition.
        place: Its place.
        timing: When members are to start and end.
    """

    members: Members

    def __init__(self, plan: Parallel, place: Place, timing: Timing) -> None:
        self.outcome = SUCCEEDED
        self._plan = plan
        self._agenda = place.agenda
        self._place = place
        self._scope: Scope = place.flow.scopes[-1]
        self._timing = timing
        self._started: dict[Flow, int] = {}
        self._ended: dict[int, float] = {}  # when each member ended [s]
        self._cut: set[int] = set()  # those that were ended when they were due; their clean-up may take time
        self._limits: list[Limit] = []

    async def run(self) -> None:
        """Start members at their times, and wait for their ends."""
        start = self._agenda.now
        indices = sorted(range(len(self._plan.members)), key=self._timing.starts.__getitem__)
        for offset, together in groupby(indices, self._timing.starts.__getitem__):
            while not self.outcome.failed and self._agenda.now < round(start + offset, TIME_DIGITS):
                await self.members.wait(until=start + offset)
            for index in together if not self.outcome.failed else ():
                self._started[self.members.start(index, self._plan.members[index])] = index
        await self.members.gather()

    def forget_limits(self) -> None:
        """The composition is over."""
        for limit in self._limits:
            limit.over = True

    # -------------------------------------------------------- ends; called between rounds

    def member_ended(self, flow: Flow) -> None:
        """A member has ended."""
        assert flow.outcome is not None
        if self.outcome.failed:
            return
        if flow.outcome.failed:
            self._fail(flow.outcome)
            return
        index = self._started[flow]
        self._ended[index] = self._agenda.now
        if len(self._started) < len(self._plan.members):
            self._later(0.0, partial(self._check_overlap, index))
        if index == 0:
            self._primary_ended()
        elif 0 in self._ended:
            if index not in self._cut:
                self._check_end(index)
        elif self._timing.ends.low > -inf:
            self._later(max(-self._timing.ends.low, 0.0), partial(self._check_early, index))

    def _primary_ended(self) -> None:
        for index in list(self._ended):
            if index != 0:
                self._check_end(index)
        high = self._timing.ends.high
        if high < inf:
            cuts = {cut for cut in self._timing.cuts if cut < inf}
            for cut in sorted(cuts | {max(high, 0.0)}):
                self._later(cut, partial(self._end_secondaries, cut))

    def _end_secondaries(self, offset: float) -> None:
        """End the open-ended members that are to end now; at the last offset, others are late."""
        high = self._timing.ends.high
        for flow in self.members.alive:
            index = self._started[flow]
            is_due = self._timing.cuts[index] <= offset <= high
            if is_due and is_open_ended(self._agenda, flow.scopes[0]):
                self._cut.add(index)
                self.members.end(flow, SUCCEEDED)
            elif offset >= high:
                when = (
                    f"{offset:g} s after the primary member ended" if offset else "when the primary member ended"
                )
                self._fail(
                    failure(f"`{self._name(index)}` was still running {when}", self._plan.members[index].span)
                )
                return

    # -------------------------------------------------------- failures; called between rounds

    def _check_overlap(self, index: int) -> None:
        """There has to be an instant in which all members run."""
        if len(self._started) < len(self._plan.members):
            waiting = next(
                other for other in range(len(self._plan.members)) if other not in self._started.values()
            )
            reason = f"`{self._name(index)}` ended before `{self._name(waiting)}` started"
            self._fail(failure(reason, self._plan.members[index].span))

    def _check_early(self, index: int) -> None:
        """A secondary member has ended, and the primary one should not be running any more."""
        if 0 not in self._ended:
            reason = f"`{self._name(index)}` ended before the primary member, which is still running"
            self._fail(failure(reason, self._plan.members[index].span))

    def _check_end(self, index: int) -> None:
        """Both a secondary member and the primary one have ended."""
        low, high = self._timing.ends.low, self._timing.ends.high
        offset = round(self._ended[index] - self._ended[0], TIME_DIGITS)
        if not round(low, TIME_DIGITS) <= offset <= round(high, TIME_DIGITS):
            relation = f"{abs(offset):g} s {'before' if offset < 0 else 'after'}" if offset else "together with"
            reason = (
                f"`{self._name(index)}` ended {relation} the primary member, and should have {_due(low, high)}"
            )
            self._fail(failure(reason, self._plan.members[index].span))

    def _fail(self, outcome: Outcome) -> None:
        if self.outcome.failed:
            return
        self.outcome = explained(outcome, self._place, self._scope)
        for other in self.members.alive:
            self._agenda.end_flow(other, Outcome(Status.CANCELLED, "a parallel member failed"))
        self.members.wake()

    def _later(self, delay: float, check: Callable[[], None]) -> None:
        """Check something after a delay [s], when the instant has otherwise settled."""

        def act() -> None:
            if not self.outcome.failed:
                check()

        limit = Limit(self._scope, act)
        self._limits.append(limit)
        self._agenda.at(self._agenda.now + delay, limit)

    def _name(self, index: int) -> str:
        return name_of(self._plan.members[index])


def _due(low: float, high: float) -> str:
    """When a secondary member should have ended."""
    if low == high:
        if low == 0:
            return "ended with it"
        return f"ended {abs(low):g} s {'before' if low < 0 else 'after'} it"
    bounds = (f"at least {low:g} s" if low > -inf else "", f"at most {high:g} s" if high < inf else "")
    return f"ended {' and '.join(filter(None, bounds))} after it"
