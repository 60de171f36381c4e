"""Modifiers (7.3.12). Python implements atomic ones; a compound modifier applies others, constrains, and reacts.
Its instance lives as long as the modified behavior, in each run. Its event contexts start with that run. Its
events `start`, `end` and `fail` are those of the modified behavior.

A function receives the behavior, including closer modifiers, as its child. Each run of the child starts it anew,
with new random draws; between two runs lies a delta cycle, so that loops without time are detected. A function may
wait for its context and its child only: other waits would block the delta cycle.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable, Coroutine, Generator, Iterable, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import replace
from functools import partial
from typing import Any, NoReturn, TypeAlias, TypeVar

from seoro.errors import BackendLost, BackendRefused
from seoro.runtime.actions.outside import Asking
from seoro.runtime.behaviors.action import judge
from seoro.runtime.behaviors.invoke import run_instance
from seoro.runtime.behaviors.limits import within_limit
from seoro.runtime.contracts.backends import Backend
from seoro.runtime.contracts.measures import CLOSEST_APPROACH, Measuring
from seoro.runtime.contracts.modifiers import Interrupt
from seoro.runtime.execution.contacts import senses
from seoro.runtime.execution.context import Carry, ExecutionContext
from seoro.runtime.execution.static_tree import place
from seoro.runtime.explanation import Explanation
from seoro.runtime.instances.applied import Applied, Modifying
from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.kernel.task import CausalPast, Waiter
from seoro.runtime.parameters.parameters import actor_of, enter_modifier
from seoro.runtime.trace.records import Trace
from seoro.runtime.values.environment import EvaluationError
from seoro.runtime.verdict import Outcome, RunStatus, Status

T = TypeVar("T")
Within: TypeAlias = Callable[[Iterable[Modifying], Carry], Carry]
"""Nests a behavior in modifications, the outermost first."""


async def run_modifier(applied: Applied, context: ExecutionContext, inner: Carry, within: Within) -> Outcome:
    """Run a modified behavior by its modifier."""
    services, name = context.services, applied.modifier.name
    services.count_start(applied.plan.span, len(context.position))
    number = services.new_id()
    path = f"{context.path}/{name}"
    fields = {"type": "modifier", "name": name, "path": path, **place(applied.plan.span)}
    trace = services.trace
    arguments = trace.exact.fields(applied.fields) if trace.is_observed else {}
    record = partial(_record, trace, context.task.past)
    record("behavior.start", id=number, parent=context.number, **fields, arguments=arguments)
    inside = context.inside(number)
    instance = enter_modifier(applied, f"{context.path}/{applied.name}")

    def carry(_: ExecutionContext) -> Awaitable[Outcome]:
        if name in services.modifiers:
            return _run_function(applied, inside, partial(_attempt, inner))
        return within(applied.modifiers, inner)(inside)

    try:
        if instance.reacts or services.covers(instance):
            own = inside.of_modifier(instance, applied.position)
            outcome = await run_instance(instance, own, carry)
        else:
            outcome = await carry(inside)
    except (asyncio.CancelledError, EvaluationError):
        record("behavior.end", id=number, status=Status.CANCELLED.value, reason="")
        raise
    record("behavior.end", id=number, status=outcome.status.value, reason=outcome.reason)
    return outcome


def _record(trace: Trace, past: CausalPast, kind: str, **fields: Any) -> None:
    """Add a record; it becomes the cause of the next records."""
    if trace.is_observed:
        past.cause = trace.record(kind, past.cause, **fields)


async def _attempt(inner: Carry, context: ExecutionContext) -> Outcome:
    """Run the modified behavior once, between records of the attempt."""
    record, modifier = partial(_record, context.services.trace, context.task.past), context.number
    record("attempt.start", modifier=modifier, path=context.path)
    try:
        if context.invoked is not None and context.invoked.is_watched:
            context.invoked.renew(context)
        outcome = await inner(context)
    except (asyncio.CancelledError, EvaluationError):
        record("attempt.end", modifier=modifier, status=Status.CANCELLED.value, reason="")
        raise
    record("attempt.end", modifier=modifier, status=outcome.status.value, reason=outcome.reason)
    return outcome


async def _run_function(applied: Applied, context: ExecutionContext, inner: Carry) -> Outcome:
    bound, span = context.services.modifiers[applied.modifier.name], applied.plan.span
    ctx = _Context(applied, context)
    child = _Child(ctx, inner)
    try:
        outcome = await _Driven(bound.call(ctx, actor_of(applied), child, applied.fields), ctx)
        if not isinstance(outcome, Outcome):
            raise TypeError(f"it returned {outcome!r}, not an `Outcome`")
    except Exception as error:
        outcome = judge(error, applied.modifier.name, span, context)
    if context.task.is_cancelled:  # regardless of the function's result
        raise asyncio.CancelledError
    if context.services.decision is not None:
        await context.task.step()  # to be cancelled by the end of the run
    if not outcome.failed or outcome.span is not None:
        return outcome
    return replace(outcome, span=span, explanation=outcome.explanation or child.explanation)


class _Driven:
    """Driver of a modifier's function that forbids all other waits.

    Args:
        coroutine: Coroutine of the function.
        ctx: Context of the function.
    """

    def __init__(self, coroutine: Coroutine[Any, Any, Outcome], ctx: _Context) -> None:
        self._coroutine = coroutine
        self._ctx = ctx

    def __await__(self) -> Generator[Any, Any, Outcome]:
        error: BaseException | None = None
        while True:
            try:
                awaited = self._coroutine.send(None) if error is None else self._coroutine.throw(error)
            except StopIteration as returned:
                return returned.value  # type: ignore[no-any-return] # checked by the caller
            if not self._ctx.is_waiting:
                error = RuntimeError("a modifier may wait for its context and its child only")
                continue
            error = None
            try:
                yield awaited
            except BaseException as thrown:
                error = thrown


class _Context:
    """`ModifierContext` of one application."""

    def __init__(self, applied: Applied, context: ExecutionContext) -> None:
        self.applied = applied
        self.span = applied.plan.span
        self.context = context
        self.is_waiting = False  # for this context or the child, as permitted

    @contextmanager
    def waiting(self) -> Generator[None]:
        """Mark a permitted wait."""
        self.is_waiting = True
        try:
            yield
        finally:
            self.is_waiting = False

    @property
    def now(self) -> float:
        return self.context.scheduler.now

    def log(self, message: str, level: str = "info") -> None:
        self.context.services.trace.log(message, level, self.span)

    def record_margin(self, distance: float, limit: float, entity: str = "") -> None:
        check = self.applied.modifier.name
        self.context.services.margins.record(check, distance, limit, self.span, entity)

    async def sleep(self, duration: float) -> None:
        waiter = Waiter(self.context.task)
        self.context.scheduler.wake_at(self.now + duration, waiter)
        await self._wait(waiter)

    async def ask(self, request: Awaitable[T]) -> T:
        with self.waiting():
            return await Asking(self.context.scheduler, self.context.task, request)

    def measuring(self, entities: Sequence[str]) -> list[tuple[Measuring, str]]:
        homes = self.context.services.homes
        found: list[tuple[Backend | Measuring | None, str]]
        if entities:
            found = [(homes.by_name(name, Measuring), name) for name in entities]
        else:
            found = [(home.backend, home.name) for home in homes.robots(())]
        if not found or any(not isinstance(backend, Measuring) for backend, _ in found):
            reason = "cannot measure robots and entities: the run has no simulator that measures all of them"
            self.context.services.decide(RunStatus.ERROR, reason, self.span)
        return [(backend, name) for backend, name in found if isinstance(backend, Measuring)]

    async def closest_approaches(self, robots: Sequence[str]) -> list[tuple[str, float]]:
        found: list[tuple[str, float]] = []
        for home in self.context.services.homes.robots(robots):
            if isinstance(home.backend, Measuring):
                with suppress(BackendRefused):  # the simulator does not measure this robot
                    distance = await self.ask(home.backend.measurement(home.name, CLOSEST_APPROACH))
                    found += [] if distance is None else [(home.name, distance)]
        return found

    async def hold(self) -> NoReturn:
        task, open_ended = self.context.task, self.context.services.open_ended
        open_ended.add(task)
        try:
            await self._wait(Waiter(task))
        finally:
            open_ended.discard(task)
        raise AssertionError("this waiter is never woken")

    async def _wait(self, waiter: Waiter) -> None:
        with self.context.waiting(self.span), self.waiting():
            await self.context.scheduler.wait(waiter)

    def allow_contact(self, entities: Sequence[str]) -> AbstractContextManager[None]:
        context = self.context
        return context.services.contacts.allow(context.position, None, frozenset(entities) or None)

    @contextmanager
    def forbid_contact(
        self, robots: Sequence[str], allowed: Sequence[str], interrupt: Interrupt, *, also_struck: bool
    ) -> Generator[None]:
        context = self.context
        services = context.services
        homes = services.homes.robots(robots)
        unobserved = [home for home in homes if not senses(home)]
        if unobserved:
            who = ", ".join(f"{home.name} of {home.backend.name}" for home in unobserved)
            reason = f"cannot forbid contacts: those of {who} are not reported"
            services.decide(RunStatus.ERROR, reason, self.span)
        contacts, names = services.contacts, frozenset(allowed)
        with (
            contacts.allow(context.position, None, names),
            contacts.forbid(context.position, homes, interrupt.trigger, also_struck=also_struck),
        ):
            yield


async def _interruptible(
    context: ExecutionContext, interrupt: Interrupt, behave: Callable[[], Awaitable[Outcome]]
) -> Outcome:
    """Carry something out, and cancel it when an interrupt is made."""
    scheduler = context.scheduler
    with CancelScope(context.task) as scope:

        def end() -> None:
            if not scope.is_cancelled:
                scope.cancel(context.explained(Outcome(Status.CANCELLED, interrupt.reason), scope))

        interrupt.on_interrupt(
            lambda: scheduler.act_in_instant(lambda: scheduler.at_commit(context.position, end))
        )
        try:
            return await behave()
        finally:
            interrupt.on_interrupt(None)
    outcome: Outcome = scope.outcome
    return outcome


class _Child:
    """`Child` of one application."""

    def __init__(self, ctx: _Context, inner: Carry) -> None:
        self._ctx = ctx
        self._inner = inner
        self._runs = 0
        self.explanation: Explanation | None = None  # of a run that was cancelled at its limit

    async def run(self, limit: float | None = None, interrupt: Interrupt | None = None) -> Outcome | None:
        context = self._ctx.context
        if context.task.is_cancelled:
            raise asyncio.CancelledError  # the modifier has not let itself be cancelled
        self._runs += 1
        context = context.run_again(self._runs)
        with self._ctx.waiting():
            if self._runs > 1:
                context.services.count_start(self._ctx.span, len(context.position))
                await context.task.step()
            behave: Callable[[], Awaitable[Outcome]] = partial(self._inner, context)
            if interrupt is not None:
                behave = partial(_interruptible, context, interrupt, behave)
            began = time.monotonic()
            if limit is None:
                outcome, is_cut_off = await behave(), False
            else:
                outcome, is_cut_off = await within_limit(context, limit, behave)
            if interrupt is not None and interrupt.reason and outcome.status is Status.CANCELLED:
                self.explanation = outcome.explanation
                return None
            if not is_cut_off:
                return outcome
            if limit and (loss := context.services.homes.loss_since(began)):
                raise BackendLost(loss)
            self.explanation = outcome.explanation
            return None
