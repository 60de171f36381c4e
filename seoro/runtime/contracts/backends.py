"""Contract of backends, which control the actors of a scenario, and types common to all of their requests.

`seoro.bridges` implements it. Units are SI, angles radians; poses are in the frame `map` unless a parameter names
another one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from typing import Any, Protocol, runtime_checkable

from seoro.errors import BackendError
from seoro.lang.frozen import Value


class GoalStatus(Enum):
    """End states of a goal or a watch."""

    SUCCEEDED = "succeeded"
    ABORTED = "aborted"
    CANCELED = "canceled"


class Report(Value):
    """Report of a backend that a goal has ended or a watch has fired.

    `interrupted` marks goals that the backend itself ended, for example after a lost connection. No action
    receives such a report: `ActionContext.report` raises instead, so that it is never mistaken for a failure of
    the robot.

    `margin` is the distance of a watched measure to its limit, negative beyond it; None of all others.
    """

    status: GoalStatus
    message: str = ""
    interrupted: bool = False
    margin: float | None = None


Reporter = Callable[[Report], None]
"""Callback for a report; called at most once, on the event loop, between instants."""

EventHandler = Callable[[str, Mapping[str, Any]], None]
"""Callback for events of the backend, with name and arguments: a contact, for example, or a `WARNING`."""

WARNING = "warning"
"""Name of a warning for users; its `message` is logged as a warning of the run."""

CONTACT = "contact"
"""Event: two entities touch. `Contact.of` reads its arguments."""

DEPARTURE = "left_world"
"""Event: a robot left its world, which fails the run; its argument `reason` becomes that of the verdict."""

EXHAUSTED = "exhausted"
"""Event: the backend has nothing more to report, which fails the run; its `reason` becomes that of the verdict."""

BACKEND_EVENTS = (CONTACT, DEPARTURE, "navigation_feedback")
"""Events that backends report."""

LossHandler = Callable[[BackendError], None]
"""Callback for the loss of the backend, with the reason; also for a stop of all motion by a person
(`BackendStopped`). Called on the event loop."""


class Backend(Protocol):
    """Controller of actors: a simulator node, or a bridge to robots. The caller of the run opens and closes it.

    A backend also implements the protocols of the other modules that it supports. Requests take no time of the
    run's clock; results of longer work are reported later. Each request raises `BackendRefused` with a reason if
    the backend refuses it, and `BackendLost` if the backend is unreachable.
    """

    @property
    def name(self) -> str:
        """Name of the backend in messages."""

    def assign_robot(self, actor: str, types: Sequence[str]) -> str | None:
        """Return the backend's own name for an actor, or None. Called once per actor, at instantiation.

        Args:
            actor: Name of the actor in the scenario.
            types: Its type and the inherited types, nearest first.
        """

    async def start_run(self, on_event: EventHandler, on_lost: LossHandler) -> None:
        """Start the run. Called once, after instantiation and before the first instant."""

    async def end_run(self) -> None:
        """Stop every robot. Called once, after the last instant and on every path."""


@runtime_checkable
class Selective(Protocol):
    """A backend that may lack some contracts whose methods it has, also for some of its robots only."""

    def reason_missing(self, contract: type, robot: str) -> str:
        """Return why a robot lacks a contract; empty if it has it."""


@runtime_checkable
class Observing(Protocol):
    """A backend that observes robots, and commands none."""

    def reason_unobeyed(self) -> str:
        """Return why its robots obey no commands."""


@runtime_checkable
class Connected(Protocol):
    """A backend whose connection may be interrupted, so that reports may be missing."""

    def loss_since(self, moment: float) -> str:
        """Return why reports may be missing since `moment`; empty if none can be missing.

        Args:
            moment: Time of `time.monotonic` [s].
        """
