"""Resources shared by the actions of one run: shared objects, background resources, exclusive uses and logs.

An action with `@action(..., uses=...)` starts when the part of its actor, such as its base, is free. Two parallel
actions that use the same part are a fault of the scenario. Once the instant of the second invocation has otherwise
settled, the run ends as an error that names both. Until then the first action may end or be cancelled. A cancelled
action is awaited, since its clean-up still uses the part.
"""

from __future__ import annotations

from collections import deque
from collections.abc import AsyncGenerator, Callable, Iterable
from contextlib import asynccontextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar, cast

from seoro.deferred import dataclass
from seoro.lang.frozen import Value
from seoro.lang.source import Span
from seoro.runtime.execution.blocking import ThreadUsage
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.task import Task, Waiter
from seoro.runtime.trace.records import Trace
from seoro.runtime.values.values import Actor
from seoro.runtime.verdict import RunStatus

if TYPE_CHECKING:
    from seoro.runtime.execution.background import BackgroundResources
T = TypeVar("T")
Decide: TypeAlias = Callable[[RunStatus, str, Span | None], None]


class Use(Value):
    """Part of an actor.

    Args:
        actor: The actor; None for a part of the run.
        what: Name of the part.
    """

    actor: Actor | None
    what: str

    def __str__(self) -> str:
        return f"`{self.what}`" + (f" of `{self.actor.name}`" if self.actor is not None else "")


@dataclass(eq=False)
class _User:
    """Invocation that uses a part, or waits for it."""

    name: str
    span: Span
    waiter: Waiter
    is_admitted: bool = False


class ExclusiveUses:
    """Exclusive uses in one run.

    Args:
        scheduler: Scheduler of the run.
        decide: Ends the run.
    """

    def __init__(self, scheduler: Scheduler, decide: Decide) -> None:
        self._scheduler = scheduler
        self._decide = decide
        self._queues: dict[Use, list[_User]] = {}  # the first of each queue uses the part

    @asynccontextmanager
    async def alone(self, use: Use, task: Task, name: str, span: Span) -> AsyncGenerator[None]:
        """Use a part exclusively during the block.

        Args:
            use: The part.
            task: Task of the user.
            name: Name of the invocation, for messages.
            span: Its text.
        """
        user = _User(name, span, Waiter(task))
        queue = self._queues.setdefault(use, [])
        # At commit, so that the order of steps does not decide which user is first.
        self._scheduler.at_commit(task.path, partial(self._enter, use, user))
        try:
            await self._scheduler.wait(user.waiter)
            yield
        finally:
            if user in queue:
                queue.remove(user)
                self._scheduler.at_commit(task.path, partial(self._admit, use))

    def _enter(self, use: Use, user: _User) -> None:
        if not user.waiter.over:  # otherwise it was cancelled in the delta cycle of its arrival
            self._queues[use].append(user)
            self._admit(use)

    def _admit(self, use: Use) -> None:
        """Admit the first user, and check for others when the instant has settled."""
        queue = self._queues[use]
        if queue and not queue[0].is_admitted:
            queue[0].is_admitted = True
            self._scheduler.wake(queue[0].waiter)
        if len(queue) > 1:
            self._scheduler.when_settled(partial(self._judge, use))

    def _judge(self, use: Use) -> None:
        queue = self._queues[use]
        if len(queue) > 1 and not queue[0].waiter.task.is_cancelled:
            first, second = queue[:2]
            reason = (
                f"`{second.name}` uses the {use} while `{first.name}` ({first.span}) uses it; "
                "one action at a time may use it"
            )
            self._decide(RunStatus.ERROR, reason, second.span)


class RunResources:
    """Resources shared by the actions of one run.

    Args:
        scheduler: Scheduler of the run.
        trace: Trace of the run.
        grace: Time for clean-up [s].
        decide: Ends the run.
    """

    def __init__(self, scheduler: Scheduler, trace: Trace, grace: float, decide: Decide) -> None:
        self._scheduler = scheduler
        self._trace = trace
        self._grace = grace
        self._decide = decide
        self._lasting: BackgroundResources | None = None
        self._shared: dict[type[Any], Any] = {}
        self._relayed: deque[tuple[str, str, Span]] = deque()
        self._blocking: set[tuple[Span, str]] = set()
        self.share = ThreadUsage()
        self.uses = ExclusiveUses(scheduler, decide)

    async def end(self) -> None:
        """Close the background resources, after the last instant."""
        if self._lasting is not None:
            await self._lasting.end()
        self._write_relayed()
        self.share.end()

    @property
    def lasting(self) -> BackgroundResources:
        """Resources that outlive the actions that open them."""
        if self._lasting is None:
            from seoro.runtime.execution.background import BackgroundResources  # noqa: PLC0415 - for few runs

            self._lasting = BackgroundResources(self._scheduler.start_beside, self._grace, self._failed)
        return self._lasting

    def _failed(self, error: Exception) -> None:
        reason = f"a background resource of an action raised {type(error).__name__}: {error}"
        self._decide(RunStatus.ERROR, reason, None)

    def shared(self, make: type[T]) -> T:
        """Return the instance of a class, created without arguments on the first call."""
        if make not in self._shared:
            self._shared[make] = make()
        return cast(T, self._shared[make])

    def relay(self, position: tuple[int, ...], messages: Iterable[tuple[str, str, Span]]) -> None:
        """Write messages that arrive between steps, with their levels and spans.

        They get an instant of their own, so that its time is that of the messages.
        """
        if not self._relayed:
            self._scheduler.react(position, self._write_relayed)
        self._relayed.extend(messages)

    def _write_relayed(self) -> None:
        while self._relayed:
            level, message, span = self._relayed.popleft()
            self._trace.log(message, level, span)

    def warn_of_blocking(self, action: str, span: Span, duration: float, where: str) -> None:
        """Warn that an action has blocked the event loop [s], once for each place in Python code."""
        if (span, where) in self._blocking:
            return
        self._blocking.add((span, where))
        message = (
            f"`{action}` blocked the event loop for {duration:.2f} s (in {where}); await slow operations, "
            "or use a plain function with `@action(..., thread=True)`"
        )
        self._trace.log(message, "warning", span)
