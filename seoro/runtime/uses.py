"""What an actor can do for one action at a time only, such as driving its base.

An action that says so at `@action(..., uses=...)` begins when it has that to itself. Two in parallel that use the
same of one actor are a fault of the scenario, and end the run as an error that names both, as soon as the instant
in which the second was invoked has otherwise settled. Until then the first may end, or be cancelled; one that is
cancelled is waited for, since its clean-up still uses the actor.
"""

from __future__ import annotations

from collections.abc import AsyncGenerator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, TypeAlias

from seoro.lang.frozen import Value
from seoro.lang.source import Span
from seoro.runtime.agenda import Agenda, Flow, Waiter
from seoro.runtime.values import Actor
from seoro.runtime.verdict import RunStatus

if TYPE_CHECKING:
    Decide: TypeAlias = Callable[[RunStatus, str, Span | None], None]


class Use(Value):
    """Something of an actor.

    Args:
        actor: Whose it is; None for something that the run has once.
        what: Its name.
    """

    actor: Actor | None
    what: str

    def __str__(self) -> str:
        return f"`{self.what}`" + (f" of `{self.actor.name}`" if self.actor is not None else "")


@dataclass(eq=False)
class _User:
    """An invocation that uses something, or is to."""

    name: str
    span: Span
    waiter: Waiter
    is_let_in: bool = False

    @property
    def flow(self) -> Flow:
        """The flow that it runs in."""
        return self.waiter.flow


class Uses:
    """Who uses what in one run.

    Args:
        agenda: Of the run.
        decide: Ends the run.
    """

    def __init__(self, agenda: Agenda, decide: Decide) -> None:
        self._agenda = agenda
        self._decide = decide
        self._queues: dict[Use, list[_User]] = {}  # the first of each uses it

    @asynccontextmanager
    async def alone(self, use: Use, flow: Flow, name: str, span: Span) -> AsyncGenerator[None]:
        """Have something to oneself in a block.

        Args:
            use: What is used.
            flow: Where.
            name: Of the invocation that uses it, for people.
            span: Its text.
        """
        user = _User(name, span, Waiter(flow))
        queue = self._queues.setdefault(use, [])
        # Between rounds, so that the order of steps does not decide who is first.
        self._agenda.after_round(flow.path, partial(self._enter, use, user))
        try:
            await self._agenda.wait(user.waiter)
            yield
        finally:
            if user in queue:
                queue.remove(user)
                self._agenda.after_round(flow.path, partial(self._go_on, use))

    def _enter(self, use: Use, user: _User) -> None:
        if not user.waiter.over:  # else it was cancelled in the round in which it came
            self._queues[use].append(user)
            self._go_on(use)

    def _go_on(self, use: Use) -> None:
        """Let the first in, and see to it that nobody else is there in the end."""
        queue = self._queues[use]
        if queue and not queue[0].is_let_in:
            queue[0].is_let_in = True
            self._agenda.fire(queue[0].waiter)
        if len(queue) > 1:
            self._agenda.when_settled(partial(self._judge, use))

    def _judge(self, use: Use) -> None:
        queue = self._queues[use]
        if len(queue) > 1 and queue[0].flow.ended is None:
            first, second = queue[:2]
            reason = (
                f"`{second.name}` uses the {use} while `{first.name}` ({first.span}) does: "
                "that is for one action at a time"
            )
            self._decide(RunStatus.ERROR, reason, second.span)
