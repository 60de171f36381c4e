"""Run slots: limit the number of runs that are active at a time.

A run that waits for busy robots lends its slot, so that it does not block other runs. Once it holds its robots, it
gets the next free slot before runs that have not begun, since others may wait for its robots. Runs with a slot
hold all their robots, so each of them ends, which prevents deadlocks.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from seoro.concurrency.condition import Condition
from seoro.executor.limits import Policy
from seoro.executor.runs.active_run import ActiveRun

# Limit of runs that wait for robots: beyond it, no run starts that may have to wait. Each has a process, which
# polls four times a second.
MOST_LENT: Final = 10


class RunSlots:
    """Slots of an executor.

    Args:
        jobs: Number of slots.
        policy: Limits of clients.
        changes: Notified of each change.
    """

    def __init__(self, jobs: int, policy: Policy, changes: Condition) -> None:
        self._jobs = jobs
        self._policy = policy
        self._changes = changes
        self._having: list[ActiveRun] = []
        self._lent: list[ActiveRun] = []
        self._returning: list[ActiveRun] = []  # lent runs with their robots, the most urgent first

    @property
    def taken(self) -> int:
        """Number of runs with a slot."""
        return len(self._having)

    @property
    def lent(self) -> Sequence[ActiveRun]:
        """Runs that have lent their slot."""
        return self._lent

    def is_free_for(self, live: ActiveRun) -> bool:
        """Whether a run that has not begun may get a slot."""
        if live.may_wait and len(self._lent) >= MOST_LENT:
            return False
        return self.is_free_again_for(live)

    def is_free_again_for(self, live: ActiveRun) -> bool:
        """Whether a run that has lent its slot would get one at once."""
        return self._may_have(live) and not any(map(self._may_have, self._returning))

    def acquire(self, live: ActiveRun) -> None:
        """Give a free slot to a run."""
        self._having.append(live)

    def lend(self, live: ActiveRun) -> bool:
        """Release the slot of a run that waits for robots; False if it has none."""
        if live not in self._having:
            return False
        self._having.remove(live)
        self._lent.append(live)
        self._changes.notify_all()
        return True

    async def acquire_again(self, live: ActiveRun) -> None:
        """Wait until a run that has lent its slot gets one; a stopped run gets none."""
        self._returning.append(live)
        self._returning.sort(key=lambda each: -each.info.priority)
        await self._changes.wait_for(lambda: self._is_next(live))
        self._returning.remove(live)
        self._lent.remove(live)
        self._having.append(live)

    def may_have_any(self, live: ActiveRun) -> bool:
        """Whether the limits of its client permit another slot for a run, if one were free."""
        most = self._policy.of(live.submission.role).running
        theirs = sum(other.info.by == live.info.by for other in self._having)
        return most is None or theirs < most

    def _is_next(self, live: ActiveRun) -> bool:
        return live is next(filter(self._may_have, self._returning), None)

    def _may_have(self, live: ActiveRun) -> bool:
        return len(self._having) < self._jobs and not live.is_stopped and self.may_have_any(live)

    def release(self, live: ActiveRun) -> None:
        """Release all of a finished run."""
        for runs in (self._having, self._lent, self._returning):
            if live in runs:
                runs.remove(live)
        self._changes.notify_all()
