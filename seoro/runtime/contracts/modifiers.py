"""Contracts of Python functions that implement modifiers.

All times are times of the run's clock.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from contextlib import AbstractContextManager
from typing import NoReturn, Protocol, TypeVar

from seoro.runtime.contracts.measures import Measuring
from seoro.runtime.verdict import Outcome

T = TypeVar("T")


class Child(Protocol):
    """The behavior that a modifier is applied to, including the modifiers closer to it."""

    async def run(self, limit: float | None = None, interrupt: Interrupt | None = None) -> Outcome | None:
        """Run the behavior from its start; each call runs it again.

        If the modifier is cancelled while it waits here, the behavior is cancelled too.

        Args:
            limit: Time limit [s]. It acts when the instant has otherwise settled, so that 0 allows the behavior
                the instant in which it starts.
            interrupt: Interrupt that may end the behavior early.

        Returns:
            The outcome, succeeded or failed; None if the limit or the interrupt cancelled the behavior, after its
            clean-up.
        """


class Interrupt:
    """Ends a running behavior immediately with a reason, for conditions other than time."""

    def __init__(self) -> None:
        self.reason = ""
        self._act: Callable[[], None] | None = None

    def on_interrupt(self, act: Callable[[], None] | None) -> None:
        """Set the callback, replacing the previous one."""
        self._act = act

    def trigger(self, reason: str) -> None:
        """End the behavior. Only the first call has an effect."""
        if not self.reason:
            self.reason = reason
            if self._act is not None:
                self._act()


class ModifierContext(Protocol):
    """The run as seen by one application of a modifier."""

    @property
    def now(self) -> float:
        """Time since the start of the run [s]."""

    def log(self, message: str, level: str = "info") -> None:
        """Write a message into the trace; levels are `debug`, `info`, `warning` and `error`."""

    def record_margin(self, distance: float, limit: float, entity: str = "") -> None:
        """Record how far a checked value was from its limit; the least margin of a run is in its verdict.

        Args:
            distance: Distance of the value to the limit, negative beyond it.
            limit: The limit, in the same unit.
            entity: Entity whose value it is; empty without one.
        """

    async def sleep(self, duration: float) -> None:
        """Wait for a duration [s]."""

    async def ask(self, request: Awaitable[T]) -> T:
        """Await a request to a backend. It takes no time of the run's clock."""

    def measuring(self, entities: Sequence[str]) -> Sequence[tuple[Measuring, str]]:
        """Return backends with the names of entities there; the robots of all actors if empty.

        A backend that does not measure ends the run as an error.
        """

    async def closest_approaches(self, robots: Sequence[str]) -> Sequence[tuple[str, float]]:
        """Return the least distance of robots to any entity so far [m], from above, where it is measured.

        Args:
            robots: Names of robots in their simulator; all robots of actors if empty.
        """

    async def hold(self) -> NoReturn:
        """Wait until the modifier is cancelled; the modified behavior then has no end of its own."""

    def allow_contact(self, entities: Sequence[str]) -> AbstractContextManager[None]:
        """Allow robots to touch entities within the behavior during the block; all entities if empty."""

    def forbid_contact(
        self, robots: Sequence[str], allowed: Sequence[str], interrupt: Interrupt, *, also_struck: bool
    ) -> AbstractContextManager[None]:
        """Interrupt the behavior during the block when a robot strikes an entity that is not allowed.

        Args:
            robots: Names of robots in their simulator; all robots of actors if empty.
            allowed: Entities that they may touch, in addition to those allowed around and within the behavior.
            interrupt: Interrupt of the modified behavior.
            also_struck: Whether to count contacts in which the robot was struck.

        Raises:
            ActionFailed: A robot is unknown.
        """
