"""What the actions of one run have in common: what they share, leave open, have to themselves and tell."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from typing import Any, TypeAlias, TypeVar, cast

from anyio.abc import TaskGroup

from seoro.lang.source import Span
from seoro.runtime.agenda import Agenda
from seoro.runtime.blocking import Share
from seoro.runtime.lasting import Lasting
from seoro.runtime.trace import Trace
from seoro.runtime.uses import Uses
from seoro.runtime.verdict import RunStatus

T = TypeVar("T")
Decide: TypeAlias = Callable[[RunStatus, str, Span | None], None]


class Common:
    """What the actions of one run have in common.

    Args:
        agenda: Of the run.
        trace: Of the run.
        grace: Time for clean-up [s].
        decide: Ends the run.
    """

    def __init__(self, agenda: Agenda, trace: Trace, grace: float, decide: Decide) -> None:
        self._agenda = agenda
        self._trace = trace
        self._grace = grace
        self._decide = decide
        self._lasting: Lasting | None = None
        self._shared: dict[type[Any], Any] = {}
        self._relayed: deque[tuple[str, str, Span]] = deque()
        self._blocking: set[tuple[Span, str]] = set()
        self.share = Share()
        self.uses = Uses(agenda, decide)

    def begin(self, group: TaskGroup) -> None:
        """The run begins; what lasts is open in tasks of this group."""
        self._lasting = Lasting(group, self._grace, self._failed)
        self.share.begin()

    async def end(self) -> None:
        """Close what is open, after the last instant."""
        await self.lasting.end()
        self._write_relayed()
        self.share.end()

    @property
    def lasting(self) -> Lasting:
        """What outlives the actions that open it."""
        assert self._lasting is not None, "actions run while the run does"
        return self._lasting

    def _failed(self, error: Exception) -> None:
        reason = f"what an action left open raised {type(error).__name__}: {error}"
        self._decide(RunStatus.ERROR, reason, None)

    def shared(self, make: type[T]) -> T:
        """The one object of a class, made without arguments."""
        if make not in self._shared:
            self._shared[make] = make()
        return cast(T, self._shared[make])

    def relay(self, position: tuple[int, ...], messages: Iterable[tuple[str, str, Span]]) -> None:
        """Write messages that come between steps, with their levels and places in the scenario.

        They get an instant of their own, so that its time is theirs.
        """
        if not self._relayed:
            self._agenda.react(position, self._write_relayed)
        self._relayed.extend(messages)

    def _write_relayed(self) -> None:
        while self._relayed:
            level, message, span = self._relayed.popleft()
            self._trace.log(message, level, span)

    def warn_of_blocking(self, action: str, span: Span, duration: float, where: str) -> None:
        """An action has held the event loop for so long [s]; that is told once for each place in Python."""
        if (span, where) in self._blocking:
            return
        self._blocking.add((span, where))
        message = (
            f"`{action}` blocked everything else for {duration:.2f} s (in {where}); await what takes time, "
            "or make it a plain function with `@action(..., thread=True)`"
        )
        self._trace.log(message, "warning", span)
