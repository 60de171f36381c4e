"""`Settling`: actions at the end of an instant, when no step is left.

Contract: choices act first, then deadlines, then the rest. After each the instant continues, and settles again. Of
nested scopes, the inner ones act first: their effects may spare the outer ones.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Generator, Sequence
from types import coroutine
from typing import Any, Final

from seoro.runtime.kernel.delta import Effects
from seoro.runtime.kernel.task import Task
from seoro.runtime.kernel.timers import Deadline


class Settling:
    """Actions that wait for the end of the present instant."""

    def __init__(self) -> None:
        self.choices: list[Deadline] = []
        self.deadlines: list[Deadline] = []  # reached
        self.rest: list[Callable[[], None]] = []  # called after choices and deadlines

    @property
    def is_waited_for(self) -> bool:
        """Whether any action may be waiting."""
        return bool(self.choices or self.deadlines or self.rest)

    def act(self, cancellations: Effects, *, with_deadlines: bool) -> bool:
        """Perform the next actions.

        Args:
            cancellations: Cancellations of the delta cycle; choices and deadlines are added to them.
            with_deadlines: Whether deadlines may act.

        Returns:
            Whether there were any.
        """
        made: list[Deadline] = []
        if self.choices:
            made, self.choices = _split(self.choices)
        if not made and self.deadlines and with_deadlines:
            made, self.deadlines = _split(self.deadlines)
        if made:
            for each in made:
                each.over = True
                cancellations.append((each.scope.task.path, each.act, each.cause))
            return True
        if not self.rest:
            return False
        acts, self.rest = self.rest, []
        for act in acts:
            act()
        return True


def _split(deadlines: Sequence[Deadline]) -> tuple[list[Deadline], list[Deadline]]:
    """Split the active deadlines into those without a nested one, and the rest."""
    deadlines = [deadline for deadline in deadlines if not deadline.over]
    if len(deadlines) < 2:
        return deadlines, []
    around = {scope for deadline in deadlines for scope in deadline.scope.around}
    return [each for each in deadlines if each.scope not in around], [
        each for each in deadlines if each.scope in around
    ]


class _Ready:
    """Awaitable that is done at once."""

    def __await__(self) -> Generator[None, None, None]:
        yield from ()


READY: Final = _Ready()


@coroutine
def parked(task: Task, future: asyncio.Future[Any]) -> Generator[Any, None, Any]:
    """Await the future that resumes a task. A task resumed by its own parking continues without a switch."""
    try:
        return (yield from future)
    except asyncio.CancelledError:
        task.cancel_seen_next = False
        raise
    finally:
        task.parked = None
