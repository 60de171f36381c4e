"""Fair queue of runs: by priority, then round-robin among clients.

The client that was served least recently is next, so that a client with many runs does not block the others. Each
client waits for the active runs and one run of every other client. Runs of one client keep their order.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType


class FairQueue:
    """Ids of waiting runs."""

    def __init__(self) -> None:
        self._runs: dict[int, dict[str, dict[str, None]]] = {}  # by priority and submitter, in order
        self._where: dict[str, tuple[int, str]] = {}  # priority and submitter
        self._served: dict[str, int] = {}  # last turn of each client
        self._turn = 0
        self._places: Mapping[str, int] | None = None  # cache

    def __contains__(self, run: str) -> bool:
        return run in self._where

    def __iter__(self) -> Iterator[str]:
        return iter(self._where)

    def __len__(self) -> int:
        return len(self._where)

    def add(self, run: str, priority: int, submitter: str) -> None:
        """Add a run."""
        self._where[run] = priority, submitter
        self._runs.setdefault(priority, {}).setdefault(submitter, {})[run] = None
        self._places = None

    def discard(self, run: str) -> None:
        """Remove a run."""
        priority, submitter = self._where.pop(run)
        submitters = self._runs[priority]
        del submitters[submitter][run]
        if not submitters[submitter]:
            del submitters[submitter]
        if not submitters:
            del self._runs[priority]
        self._places = None

    def first(self, may: Callable[[str], bool]) -> str | None:
        """Return the next run that may start, or None."""
        return next(filter(may, self._ordered()), None)

    def take(self, run: str | None = None) -> str:
        """Remove a run that starts, by default the next one, and count it for its client."""
        run = next(self._ordered()) if run is None else run
        _, submitter = self._where[run]
        self.discard(run)
        self._turn += 1
        self._served[submitter] = self._turn
        if not self._where:
            self._served.clear()
        return run

    @property
    def places(self) -> Mapping[str, int]:
        """Position of each run in the queue, from 1 on."""
        if self._places is None:
            self._places = MappingProxyType({run: place for place, run in enumerate(self._ordered(), 1)})
        return self._places

    def _ordered(self) -> Iterator[str]:
        served, turn = dict(self._served), self._turn
        for priority in sorted(self._runs, reverse=True):
            submitters = self._runs[priority].items()
            turns = [(served.get(name, 0), at, name, iter(runs)) for at, (name, runs) in enumerate(submitters)]
            heapq.heapify(turns)
            while turns:
                _, at, name, runs = turns[0]
                run = next(runs, None)
                if run is None:
                    heapq.heappop(turns)
                    continue
                yield run
                turn += 1
                served[name] = turn
                heapq.heapreplace(turns, (turn, at, name, runs))
