"""Goals and watches of a node, each a task that ends in an occurrence."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Awaitable, Callable, Container, Iterable
from dataclasses import dataclass, field

import anyio
from anyio.abc import TaskGroup

from seoro.bridges.serving.event_log import EventLog
from seoro.bridges.wire import GoalWarning, Occurrence, Outcome, Result
from seoro.bridges.wire.refusal import RequestRefused, check_id

MOST = 1000  # goals and watches of a node

log = logging.getLogger(__name__)


class GoalAborted(Exception):
    """A goal cannot be reached; the message has the reason."""


class GoalInterrupted(Exception):
    """A goal was ended by the bridge or by the connection to the robot; no verdict on the robot."""


@dataclass
class _Item:
    """Goal of a part of a robot, or a watch (without a robot): its cancel scope and its end."""

    robot: str | None
    part: str
    scope: anyio.CancelScope = field(default_factory=anyio.CancelScope)
    over: anyio.Event = field(default_factory=anyio.Event)
    reason: str = ""  # reason of the node to interrupt it


class Work:
    """Goals and watches by the ids that clients give them.

    Args:
        tasks: Group of their tasks.
        events: Log of their ends.
    """

    def __init__(self, tasks: TaskGroup, events: EventLog) -> None:
        self._tasks = tasks
        self._events = events
        self._items: dict[str, _Item] = {}
        self._doubtful: Counter[str] = Counter()  # cancelled goals that may continue, by robot

    def start(
        self,
        identifier: str,
        work: Callable[[], Awaitable[str]],
        *,
        robot: str | None = None,
        part: str = "",
        begin: Callable[[], None] = lambda: None,
    ) -> None:
        """Start a goal of a robot, or a watch.

        Args:
            identifier: Id of the goal or watch.
            work: Succeeds when it returns, with a message for people. It aborts by `GoalAborted`, and is
                interrupted by `GoalInterrupted`, any other exception, and `interrupt`. It cleans up when it is
                cancelled.
            robot: Robot of the goal; None for a watch.
            part: Part of the robot with one goal at a time, such as its gripper.
            begin: Called first, if the goal is accepted: the task of `work` begins later.

        Raises:
            RequestRefused: The id is in use, or the robot has a goal.
        """
        check_id(identifier)
        if identifier in self._items:
            raise RequestRefused(Result.INCORRECT_STATE, f"duplicate id '{identifier}' of a goal or a watch")
        if robot is not None:
            self.check_free(robot, part)
        if len(self._items) >= MOST:
            raise RequestRefused(Result.OPERATION_FAILED, f"too many goals and watches; expected at most {MOST}")
        begin()
        item = self._items[identifier] = _Item(robot, part)
        self._tasks.start_soon(self._run, identifier, item, work)

    def check_free(self, robot: str, part: str = "") -> None:
        """Check that a part of a robot has no active goal.

        Raises:
            RequestRefused: It has one.
        """
        for identifier, item in self._items.items():
            if (item.robot, item.part) == (robot, part):
                does = f"the {part} of {robot} is moving" if part else f"{robot} is driving"
                raise RequestRefused(
                    Result.INCORRECT_STATE, f"{does} to goal '{identifier}': cancel it, or wait for its end"
                )

    async def cancel(self, identifier: str) -> None:
        """Cancel a goal or a watch, and wait until it has cleaned up.

        Raises:
            RequestRefused: The id is unknown.
        """
        item = self._items.get(identifier)
        if item is None:
            raise RequestRefused(Result.NOT_FOUND, f"unknown goal or watch '{identifier}'")
        item.scope.cancel()
        await item.over.wait()

    async def interrupt(self, reason: str, robots: Container[str]) -> None:
        """Interrupt all goals of robots for a reason, and wait until they have cleaned up."""
        ended = [item for item in self._items.values() if item.robot is not None and item.robot in robots]
        for item in ended:
            item.reason = reason
            item.scope.cancel()
        for item in ended:
            await item.over.wait()

    def warn(self, identifier: str, message: str) -> None:
        """Send a warning about a goal to its client."""
        self._events.add(warning=GoalWarning(id=identifier, message=message))

    def mark_unsettled(self, robot: str) -> None:
        """Count a cancelled goal of a robot that may continue, until `mark_settled`."""
        self._doubtful[robot] += 1

    def mark_settled(self, robot: str) -> None:
        """Uncount a cancelled goal of a robot."""
        self._doubtful[robot] -= 1

    def busy(self, robots: Iterable[str]) -> tuple[str, ...]:
        """Return the robots with goals, also with cancelled ones that may continue."""
        having = {item.robot for item in self._items.values()} | set(+self._doubtful)
        return tuple(robot for robot in robots if robot in having)

    async def cancel_all(self, prefix: str) -> None:
        """Cancel the goals and watches of a client by the prefix of their ids, and wait for their clean-up."""
        for identifier, item in list(self._items.items()):
            if identifier.startswith(prefix):
                item.scope.cancel()
                await item.over.wait()

    async def _run(self, identifier: str, item: _Item, work: Callable[[], Awaitable[str]]) -> None:
        outcome, message, interrupted = Outcome.CANCELED, "", False
        try:
            with item.scope:
                message = await work()
                outcome = Outcome.SUCCEEDED
        except GoalAborted as aborted:
            outcome, message = Outcome.ABORTED, str(aborted)
        except GoalInterrupted as reason:
            outcome, message, interrupted = Outcome.ABORTED, str(reason), True
        except Exception as error:
            log.exception("fault in goal or watch %s", identifier)
            outcome, message = Outcome.ABORTED, f"fault in the bridge: {type(error).__name__}: {error}"
            interrupted = True
        finally:
            del self._items[identifier]
            if outcome is Outcome.CANCELED and item.reason:
                outcome, message, interrupted = Outcome.ABORTED, item.reason, True
            self._report_end(identifier, outcome, message, interrupted=interrupted)
            item.over.set()

    def _report_end(self, identifier: str, outcome: Outcome, message: str, *, interrupted: bool) -> None:
        now = self._events.now
        self._events.add(
            occurrence=Occurrence(
                id=identifier, time=now, outcome=outcome, message=message, interrupted=interrupted
            )
        )
