"""`Debugger`: pauses a run at the starts and ends of behaviors, or while time passes.

A run is paused in the step of a task: no other task takes a step, and time stands still. So a paused run
has the same trace as one that is not paused.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from enum import Enum
from typing import TYPE_CHECKING

from seoro.lang.frozen import Value
from seoro.runtime.debug.breakpoints import Breakpoints
from seoro.runtime.execution.context import BehaviorScope
from seoro.runtime.kernel.task import Scope, Task

if TYPE_CHECKING:
    from seoro.runtime.execution.services import Services


class Step(Enum):
    """Next pause of a run that continues."""

    NONE = "none"  # at a breakpoint
    PAUSE = "pause"  # as soon as possible, also while time passes
    RECORD = "record"  # at the next start or end of a behavior
    INSTANT = "instant"  # at the next start or end at a later time
    OVER = "over"  # before the next behavior that is not inside the present one
    INTO = "into"  # before the next behavior of this branch
    OUT = "out"  # after the composition around the present behavior


class Reason(Enum):
    """Reason of a pause."""

    ENTRY = "entry"
    BREAKPOINT = "breakpoint"
    STEP = "step"
    PAUSE = "pause"


class Pause(Value):
    """A pause of a run.

    Args:
        reason: Its reason.
        time: Time of the run [s].
        scope: Behavior that starts or has ended; None while time passes.
        has_ended: Whether the behavior has ended.
    """

    reason: Reason
    time: float
    scope: BehaviorScope | None
    has_ended: bool


class Debugger:
    """Control of one run. Pass it as the option `debugger`; call its methods in the event loop of the run.

    Args:
        stop_on_entry: Whether the run pauses before its first behavior.

    Attributes:
        breakpoints: Breakpoints of the run.
        pause_state: The present pause, or None.
        on_pause: Called with each pause.
        on_resume: Called when the run continues.
    """

    def __init__(self, *, stop_on_entry: bool = False) -> None:
        self.breakpoints = Breakpoints()
        self.on_pause: Callable[[Pause], object] = lambda pause: None
        self.on_resume: Callable[[], object] = lambda: None
        self.pause_state: Pause | None = None
        self._services: Services | None = None
        self._step = Step.RECORD if stop_on_entry else Step.NONE
        self._reason = Reason.ENTRY
        self._from: Pause | None = None  # the last one
        self._turn = asyncio.Lock()  # tasks of one delta cycle pause one after the other
        self._continued = asyncio.Event()
        self._paused = asyncio.Event()
        self._is_released = False

    # -------------------------------------------------------- control

    @property
    def services(self) -> Services:
        """Services of the run.

        Raises:
            RuntimeError: The run has not begun.
        """
        if self._services is None:
            raise RuntimeError("the run has not begun")
        return self._services

    @property
    def wants_pause(self) -> bool:
        """Whether the run is to pause as soon as possible."""
        return self._step is Step.PAUSE and not self._is_released

    @property
    def has_begun(self) -> bool:
        """Whether the run has begun."""
        return self._services is not None

    def pause(self) -> None:
        """Pause as soon as possible: at the next start or end of a behavior, or while time passes."""
        if self.pause_state is None:
            self._step, self._reason = Step.PAUSE, Reason.PAUSE

    def resume(self, step: Step = Step.NONE) -> None:
        """Continue a paused run.

        Args:
            step: The next pause.
        """
        self._step, self._reason = step, Reason.STEP
        self._from, self.pause_state = self.pause_state, None
        self.on_resume()
        self._continued.set()

    def release(self) -> None:
        """Continue without further pauses: the run ends, or the editor has left."""
        self._is_released = True
        self.resume()

    async def wait_paused(self) -> Pause:
        """Wait for a pause, and return it."""
        while self.pause_state is None:
            self._paused.clear()
            await self._paused.wait()
        return self.pause_state

    # -------------------------------------------------------- called by the run

    def begin(self, services: Services) -> None:
        """Note the services of the run, before its first step."""
        self._services = services

    async def before(self, scope: Scope) -> None:
        """Pause if the behavior that starts in a scope is at a breakpoint, or the next step."""
        await self._visit(scope, has_ended=False)

    async def after(self, scope: Scope) -> None:
        """Pause if the end of the behavior of a scope is the next step."""
        await self._visit(scope, has_ended=True)

    async def while_time_passes(self) -> None:
        """Pause if this was asked for, between two steps of time."""
        if self.wants_pause:
            await self._hold(Pause(Reason.PAUSE, self.services.scheduler.now, None, False))

    async def _visit(self, scope: Scope, *, has_ended: bool) -> None:
        assert isinstance(scope, BehaviorScope), "behaviors run in these"
        if self._is_released:
            return
        async with self._turn:
            reason = self._reason_to_pause(scope, has_ended=has_ended)
            if reason is not None:
                await self._hold(Pause(reason, self.services.scheduler.now, scope, has_ended))

    def _reason_to_pause(self, scope: BehaviorScope, *, has_ended: bool) -> Reason | None:
        if self._is_released:
            return None
        if not has_ended and self.breakpoints.is_met(scope.behavior.span, scope.context.environment):
            return Reason.BREAKPOINT
        return self._reason if self._is_next(scope, has_ended=has_ended) else None

    def _is_next(self, scope: BehaviorScope, *, has_ended: bool) -> bool:
        """Whether the present step ends here."""
        if self._step in (Step.NONE, Step.PAUSE, Step.RECORD):
            return self._step is not Step.NONE
        if self._step is Step.INSTANT:
            return self._from is None or self.services.scheduler.now > self._from.time
        if has_ended or self._from is None or self._from.scope is None:
            return not has_ended
        start = self._from.scope
        if not _is_same_branch(scope.task, start.task):
            return self._step is Step.INTO and _is_inside(scope, start)
        if self._step is Step.INTO:
            return True
        is_out = not _is_inside(scope, start)
        return is_out and (self._step is Step.OVER or len(scope.context.position) < len(start.context.position))

    async def _hold(self, pause: Pause) -> None:
        self.pause_state = pause
        self._step = Step.NONE
        self._continued.clear()
        self._paused.set()
        self.on_pause(pause)
        while self.pause_state is not None:
            await self._continued.wait()


def _is_same_branch(task: Task, start: Task) -> bool:
    """Whether a task is another one or was its ancestor."""
    return start.path[: len(task.path)] == task.path


def _is_inside(scope: BehaviorScope, start: BehaviorScope) -> bool:
    """Whether a behavior is part of another one."""
    around = start.context.position
    return scope.context.position[: len(around)] == around
