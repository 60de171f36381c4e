"""Contract of engines, which carry out the runs of a campaign, in processes of this machine or elsewhere."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from typing import Protocol

from seoro.campaign.runs import Planned, Row


class WorkerDied(Exception):
    """A worker has died or hangs; the message has the cause."""


class MachineLost(WorkerDied):
    """The machine of a worker is lost, which is hardly the fault of its run."""


class Killed(WorkerDied):
    """A worker or its simulator was killed from outside, which is hardly the fault of its run."""


class NotBegun(WorkerDied):
    """None of the runs without a row had begun; they cost no attempt."""


class Engine(Protocol):
    """Carries out runs."""

    @property
    def slots(self) -> int:
        """Number of chunks that it takes at once; may grow and shrink."""

    async def slots_changed(self) -> None:
        """Wait until `slots` may have changed.

        Raises:
            UsageError, BackendError: The engine cannot carry out the campaign.
        """

    def run(self, runs: Sequence[Planned]) -> AsyncIterator[Row]:
        """Carry out a chunk of runs, and yield their rows as they end. The rows are stored.

        Raises:
            WorkerDied: The runs without a row were lost; the first of them had begun, unless it is `NotBegun`.
            BackendError: No worker can be started.
        """

    def stop(self) -> None:
        """Stop the runs in progress, with their clean-up, without rows for them."""
