"""How many runs of an executor go on at a time, and whose turn it is.

A run that waits for robots that others have lends its turn, so that it holds nobody up. When it has them, it gets
the next turn that is free, before those that have not begun, since it holds what others may want. Those that have
a turn have all that they need, so each of them ends, and no two wait for each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from seoro.changes import Changes
from seoro.executor.limits import Policy
from seoro.executor.live import LiveRun

# Runs that wait for robots; beyond that none begins that may have to. Each has a process, which looks four times a
# second.
MOST_LENT: Final = 10


class Turns:
    """The turns of an executor.

    Args:
        jobs: How many there are.
        policy: How many of them somebody may have.
        changes: Told of each change.
    """

    def __init__(self, jobs: int, policy: Policy, changes: Changes) -> None:
        self._jobs = jobs
        self._policy = policy
        self._changes = changes
        self._having: list[LiveRun] = []
        self._lent: list[LiveRun] = []
        self._returning: list[LiveRun] = []  # those of the lent ones who have their robots, the most urgent first

    @property
    def taken(self) -> int:
        """How many are taken."""
        return len(self._having)

    @property
    def lent(self) -> Sequence[LiveRun]:
        """The runs that have lent theirs."""
        return self._lent

    def is_free_for(self, live: LiveRun) -> bool:
        """Whether a run that has not begun may have one."""
        if live.may_wait and len(self._lent) >= MOST_LENT:
            return False
        return self.is_free_again_for(live)

    def is_free_again_for(self, live: LiveRun) -> bool:
        """Whether a run that has lent its turn would have one at once."""
        return self._may_have(live) and not any(map(self._may_have, self._returning))

    def take(self, live: LiveRun) -> None:
        """A run has a turn."""
        self._having.append(live)

    def lend(self, live: LiveRun) -> bool:
        """A run needs none for now; whether it had one."""
        if live not in self._having:
            return False
        self._having.remove(live)
        self._lent.append(live)
        self._changes.tell()
        return True

    async def take_again(self, live: LiveRun) -> None:
        """Wait until a run that has lent its turn has one; one that is stopped gets none."""
        self._returning.append(live)
        self._returning.sort(key=lambda each: -each.info.priority)
        await self._changes.wait_for(lambda: self._is_next(live))
        self._returning.remove(live)
        self._lent.remove(live)
        self._having.append(live)

    def _is_next(self, live: LiveRun) -> bool:
        return live is next(filter(self._may_have, self._returning), None)

    def _may_have(self, live: LiveRun) -> bool:
        most = self._policy.of(live.submission.role).running
        theirs = sum(other.info.by == live.info.by for other in self._having)
        return len(self._having) < self._jobs and not live.is_stopped and (most is None or theirs < most)

    def end(self, live: LiveRun) -> None:
        """A run is over."""
        for runs in (self._having, self._lent, self._returning):
            if live in runs:
                runs.remove(live)
        self._changes.tell()
