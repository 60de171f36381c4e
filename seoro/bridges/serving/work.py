"""What a node works on: goals and watches, each a task that ends in an occurrence."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Awaitable, Callable, Container, Iterable
from dataclasses import dataclass, field

import anyio
from anyio.abc import TaskGroup

from seoro.bridges.serving.happenings import HappeningLog
from seoro.bridges.wire import Caution, Occurrence, Outcome, Result
from seoro.bridges.wire.refusal import RequestRefused, check_id

MOST = 1000  # goals and watches at a time

log = logging.getLogger(__name__)


class Aborted(Exception):
    """A goal cannot be reached; says why."""


class Interrupted(Exception):
    """A goal was ended by the bridge or by the connection to the robot; no verdict on the robot."""


@dataclass
class _Item:
    """A goal or a watch: of which robot and part (none for a watch), what cancels it, and when it is over."""

    robot: str | None
    part: str
    scope: anyio.CancelScope = field(default_factory=anyio.CancelScope)
    over: anyio.Event = field(default_factory=anyio.Event)
    reason: str = ""  # why the node ends it; then it is interrupted


class Work:
    """Goals and watches by the ids that clients give them.

    Args:
        tasks: Where their tasks run.
        happenings: Where their ends are told.
    """

    def __init__(self, tasks: TaskGroup, happenings: HappeningLog) -> None:
        self._tasks = tasks
        self._happenings = happenings
        self._items: dict[str, _Item] = {}
        self._doubtful: Counter[str] = Counter()  # goals of robots that are over here, and may go on there

    def start(
        self, identifier: str, work: Callable[[], Awaitable[str]], *, robot: str | None = None, part: str = ""
    ) -> None:
        """Start a goal of a robot, or a watch.

        Args:
            identifier: Its id.
            work: Succeeds when it returns, with a sentence for people, aborts by `Aborted`, and is interrupted by
                `Interrupted`, by any other exception, and by `interrupt`. When it is
                cancelled, it leaves everything in order before it goes on with that.
            robot: Whose goal it is; None for a watch.
            part: Of the robot, which has one goal at a time, such as its gripper.

        Raises:
            RequestRefused: The id is in use, or the robot has a goal.
        """
        check_id(identifier)
        if identifier in self._items:
            raise RequestRefused(Result.INCORRECT_STATE, f"there is a goal or a watch '{identifier}' already")
        if robot is not None:
            self.check_free(robot, part)
        if len(self._items) >= MOST:
            raise RequestRefused(Result.OPERATION_FAILED, f"there are {MOST} goals and watches already")
        item = self._items[identifier] = _Item(robot, part)
        self._tasks.start_soon(self._carry, identifier, item, work)

    def check_free(self, robot: str, part: str = "") -> None:
        """Refuse, as simulators do, what a part of a robot cannot do beside the goal that it has.

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
        """Cancel a goal or a watch, and wait until it has left everything in order.

        Raises:
            RequestRefused: There is none of that id.
        """
        item = self._items.get(identifier)
        if item is None:
            raise RequestRefused(Result.NOT_FOUND, f"there is no goal or watch '{identifier}'")
        item.scope.cancel()
        await item.over.wait()

    async def interrupt(self, reason: str, robots: Container[str]) -> None:
        """End all goals of robots as interrupted for a reason; waits until they are in order."""
        ended = [item for item in self._items.values() if item.robot is not None and item.robot in robots]
        for item in ended:
            item.reason = reason
            item.scope.cancel()
        for item in ended:
            await item.over.wait()

    def caution(self, identifier: str, message: str) -> None:
        """Tell whose goal it is what people have to know of it."""
        self._happenings.tell(caution=Caution(id=identifier, message=message))

    def doubt(self, robot: str) -> None:
        """A goal of a robot has been called off, and may go on: it counts until `settle` is called."""
        self._doubtful[robot] += 1

    def settle(self, robot: str) -> None:
        """It does not go on."""
        self._doubtful[robot] -= 1

    def busy(self, robots: Iterable[str]) -> tuple[str, ...]:
        """Those robots that have goals, or may have."""
        having = {item.robot for item in self._items.values()} | set(+self._doubtful)
        return tuple(robot for robot in robots if robot in having)

    async def forget(self, prefix: str) -> None:
        """End everything whose id begins so, which is that of one client, and wait until it is in order."""
        for identifier, item in list(self._items.items()):
            if identifier.startswith(prefix):
                item.scope.cancel()
                await item.over.wait()

    async def _carry(self, identifier: str, item: _Item, work: Callable[[], Awaitable[str]]) -> None:
        outcome, message, interrupted = Outcome.CANCELED, "", False
        try:
            with item.scope:
                message = await work()
                outcome = Outcome.SUCCEEDED
        except Aborted as aborted:
            outcome, message = Outcome.ABORTED, str(aborted)
        except Interrupted as reason:
            outcome, message, interrupted = Outcome.ABORTED, str(reason), True
        except Exception as error:
            log.exception("fault in goal or watch %s", identifier)
            outcome, message = Outcome.ABORTED, f"fault in the bridge: {type(error).__name__}: {error}"
            interrupted = True
        finally:
            del self._items[identifier]
            if outcome is Outcome.CANCELED and item.reason:
                outcome, message, interrupted = Outcome.ABORTED, item.reason, True
            self._tell_end(identifier, outcome, message, interrupted=interrupted)
            item.over.set()

    def _tell_end(self, identifier: str, outcome: Outcome, message: str, *, interrupted: bool) -> None:
        now = self._happenings.now
        self._happenings.tell(
            occurrence=Occurrence(
                id=identifier, time=now, outcome=outcome, message=message, interrupted=interrupted
            )
        )
