"""`Choice`: the policy of `one_of`: which member runs to its end (see `one_of.py`)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from random import Random

from seoro.lang.plan import Behavior, OneOf, Serial, Wait
from seoro.runtime.kernel.task import Task
from seoro.runtime.kernel.task_group import TaskGroup
from seoro.runtime.verdict import CANCELLED, SUCCEEDED, Outcome, Status, failure


class Choice:
    """Decides which member of `one_of` runs.

    Args:
        plan: The composition.
        random: Draws the order in which unguarded members are tried.
    """

    group: TaskGroup

    def __init__(self, plan: OneOf, random: Random) -> None:
        self._plan = plan
        self._decided: Task | None = None
        self._held: dict[Task, Callable[[], None]] = {}  # members whose guards are over, with their resumptions
        self._is_choosing = False
        self._failures: list[Outcome] = []
        unguarded = [index for index, member in enumerate(plan.members) if not _is_guarded(member)]
        random.shuffle(unguarded)
        self._untried = unguarded

    def guarded(self, position: tuple[int, ...]) -> Iterator[tuple[int, tuple[int, ...], Behavior]]:
        """Yield the guarded members, with their indices and positions.

        Args:
            position: Position of the composition.
        """
        for index, member in enumerate(self._plan.members):
            if _is_guarded(member):
                yield index, (*position, index), member

    def draw(self) -> int | None:
        """Return the index of the next unguarded member to try; None if none is left, or a member is chosen."""
        if self._decided is not None or not self._untried:
            return None
        return self._untried.pop()

    def child_ready(self, child: Task, resume: Callable[[], None]) -> None:
        """Hold a member whose guard is over; it continues if it is chosen at the end of this instant."""
        self._held[child] = resume
        if not self._is_choosing:
            self._is_choosing = True
            self.group.choose(self._choose)

    def child_ended(self, child: Task) -> None:
        """Choose the member that has ended, if it was the invoked one."""
        outcome = _outcome_of(child)
        if outcome.failed:
            self._failures.append(outcome)
        elif self._decided is None and (outcome.status is Status.SUCCEEDED or self._was_invoked(child, outcome)):
            self._decide(child)

    def _choose(self) -> None:
        self._is_choosing = False
        able = [child for child in self._held if not child.is_cancelled]
        if able and self._decided is None:
            first = min(able, key=lambda child: child.path)
            self._decide(first)
            self._held[first]()

    def _decide(self, child: Task) -> None:
        self._decided = child
        for other in self.group.alive:
            if other is not child:
                self.group.cancel(other, child)

    def _was_invoked(self, child: Task, outcome: Outcome) -> bool:
        """Whether a member did more than wait for its guard."""
        waited = child.guard is not None or child in self._held
        return not waited and outcome.has_begun

    @property
    def outcome(self) -> Outcome:
        """Outcome of the chosen member; a failure if every member has failed."""
        if self._decided is not None:
            return _outcome_of(self._decided)
        if self._failures:
            last = self._failures[-1]
            reason = f"every member has failed; the last failure: {last.reason}"
            return failure(reason, self._plan.span, last.explanation)
        return SUCCEEDED


def _outcome_of(child: Task) -> Outcome:
    outcome: Outcome | None = child.outcome
    return CANCELLED if outcome is None else outcome


def _is_guarded(member: Behavior) -> bool:
    """Whether a member begins with a `wait`, possibly within `serial`."""
    while isinstance(member, Serial) and member.members:
        member = member.members[0]
    return isinstance(member, Wait)
