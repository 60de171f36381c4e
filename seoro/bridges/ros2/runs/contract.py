"""Runs that a node starts and stops, as its services and topics need them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from seoro.bridges.executor.messages import State
from seoro.concurrency.condition import Condition


@dataclass(frozen=True)
class RunState:
    """State of a run.

    Args:
        run: Id of the run.
        file: Name of its scenario file.
        state: State at its executor.
        reason: Reason of its end, or why its state is unknown; empty otherwise.
        announcement: Seed, simulator and robots, once known.
        is_stopping: Whether it was asked to stop.
        is_lost: Whether its executor does not answer.
    """

    run: str
    file: str
    state: State
    reason: str = ""
    announcement: str = ""
    is_stopping: bool = False
    is_lost: bool = False

    @property
    def is_over(self) -> bool:
        """Whether the run has ended, or its executor does not answer."""
        return self.is_lost or self.state.is_final

    @property
    def text(self) -> str:
        """The state in words."""
        state = "unknown" if self.is_lost else "stopping" if self.is_stopping and not self.is_over else self.state
        return f"{state}: {self.reason}" if self.reason else str(state)


class Runs(Protocol):
    """Runs of the scenario files of some folders.

    Attributes:
        changed: Notified when a state has changed.
    """

    changed: Condition

    def states(self) -> Sequence[RunState]:
        """Return the states of active runs and of the last ended ones, in the order of their starts."""

    def files(self) -> Sequence[Path]:
        """Return the scenario files in the folders."""

    async def start(self, name: str, parameters: str) -> RunState:
        """Start a run, or queue it.

        Args:
            name: Path of the scenario file, also relative to a folder and without suffix.
            parameters: Mapping of parameters to values, as YAML; may be empty.

        Raises:
            SeoroError: The file is not in a folder, is invalid, or the executor refuses it.
        """

    async def stop(self, reason: str) -> Sequence[RunState]:
        """Stop all active runs, and wait until they have cleaned up; returns their last states.

        Raises:
            SeoroError: The executor does not answer.
        """
