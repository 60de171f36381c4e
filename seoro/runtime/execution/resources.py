"""Resources shared by the actions of one run: shared objects, background resources, exclusive uses and logs."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar, cast

from seoro.lang.source import Span
from seoro.runtime.execution.blocking import ThreadUsage
from seoro.runtime.execution.exclusive_use import ExclusiveUses
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.trace.records import Trace
from seoro.runtime.verdict import RunStatus

if TYPE_CHECKING:
    from seoro.runtime.execution.background import BackgroundResources

T = TypeVar("T")
Decide: TypeAlias = Callable[[RunStatus, str, Span | None], None]


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

    def begin(self) -> None:
        """Start measuring blocking code."""
        self.share.begin()

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
