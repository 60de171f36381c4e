"""Modifiers (7.3.12): Python carries out atomic ones; a compound one is what it applies and constrains, and what
it does by itself. Its instance lives as long as what it modifies, each time that is carried out: its event
contexts start with that, and its own `start`, `end` and `fail` are those of all that it modifies.

A function gets the behavior, with the modifiers that stand closer to it, as its child. Each run of the child
starts that anew, and draws anew; between two runs lies a round, so that a loop of runs that take no time is found.
A function waits for its context and its child only: all else would hold up the round.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable, Coroutine, Generator, Iterable, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from functools import partial
from typing import Any, NoReturn, TypeAlias

from seoro.errors import BackendLost
from seoro.runtime.agenda import Waiter
from seoro.runtime.applied import Applied, Modifying
from seoro.runtime.behaviors.faults import judge
from seoro.runtime.behaviors.invoke import run_instance
from seoro.runtime.behaviors.limits import within_limit
from seoro.runtime.behaviors.members import Carry
from seoro.runtime.contacts import senses
from seoro.runtime.contracts import Interrupt
from seoro.runtime.evaluate import EvaluationError
from seoro.runtime.explain import explained
from seoro.runtime.explanation import Explanation
from seoro.runtime.place import Place
from seoro.runtime.verdict import Outcome, RunStatus, Status

Within: TypeAlias = Callable[[Iterable[Modifying], Carry], Carry]
"""How something is carried out within modifications, the outermost first."""


async def run_modifier(applied: Applied, place: Place, inner: Carry, within: Within) -> Outcome:
    """Carry out what is modified, by its modifier."""
    services, name = place.services, applied.modifier.name
    services.count_start(applied.plan.span, len(place.position))
    number = services.new_id()
    path, source = f"{place.path}/{name}", str(applied.plan.span)
    fields = {"type": "modifier", "name": name, "path": path, "source": source}
    trace = services.trace
    arguments = trace.exact.fields(applied.fields) if trace.is_observed else {}
    trace.record("behavior.start", id=number, parent=place.parent, **fields, arguments=arguments)
    inside = place.inside(number)
    instance = applied.enter(f"{place.path}/{applied.name}", services.plan.structures)

    def carry(_: Place) -> Awaitable[Outcome]:
        if name in services.modifiers:
            return _run_function(applied, inside, partial(_attempt, inner))
        return within(applied.modifiers, inner)(inside)

    try:
        if instance.reacts or services.coverage.concerns(instance):
            own = replace(inside, path=instance.path, position=(*place.position, *applied.position))
            outcome = await run_instance(instance, own, carry)
        else:
            outcome = await carry(inside)
    except (asyncio.CancelledError, EvaluationError):
        trace.record("behavior.end", id=number, status=Status.CANCELLED.value, reason="")
        raise
    trace.record("behavior.end", id=number, status=outcome.status.value, reason=outcome.reason)
    return outcome


async def _attempt(inner: Carry, place: Place) -> Outcome:
    """Carry out what is modified once, between records of its own."""
    trace, modifier = place.services.trace, place.parent
    trace.record("attempt.start", modifier=modifier, path=place.path)
    try:
        if place.invoked is not None and place.invoked.is_watched:
            place.invoked.renew(place)
        outcome = await inner(place)
    except (asyncio.CancelledError, EvaluationError):
        trace.record("attempt.end", modifier=modifier, status=Status.CANCELLED.value, reason="")
        raise
    trace.record("attempt.end", modifier=modifier, status=outcome.status.value, reason=outcome.reason)
    return outcome


async def _run_function(applied: Applied, place: Place, inner: Carry) -> Outcome:
    bound, span = place.services.modifiers[applied.modifier.name], applied.plan.span
    arguments = {name: applied.fields[name] for name in applied.modifier.structure.fields}
    waiting = _Waiting()
    context, child = _Context(applied, place, waiting), _Child(applied, place, inner, waiting)
    try:
        outcome = await _Driven(bound.call(context, applied.actor, child, arguments), waiting)
        if not isinstance(outcome, Outcome):
            raise TypeError(f"it returned {outcome!r}, not an `Outcome`")
    except Exception as error:
        outcome = judge(error, applied.modifier.name, span, place)
    if place.flow.ended is not None:  # it was cancelled, whatever it makes of that
        raise asyncio.CancelledError
    if place.services.decision is not None:
        await place.agenda.step(place.flow)  # to be cancelled by the end of the run
    if not outcome.failed or outcome.span is not None:
        return outcome
    return replace(outcome, span=span, explanation=outcome.explanation or child.explanation)


class _Waiting:
    """Whether a function waits for what it has been given."""

    def __init__(self) -> None:
        self.is_given = False

    @contextmanager
    def given(self) -> Generator[None]:
        """While it waits for its context or its child."""
        self.is_given = True
        try:
            yield
        finally:
            self.is_given = False


class _Driven:
    """A function of a modifier, driven such that it waits for nothing else.

    Args:
        coroutine: What it returned.
        waiting: What it waits for.
    """

    def __init__(self, coroutine: Coroutine[Any, Any, Outcome], waiting: _Waiting) -> None:
        self._coroutine = coroutine
        self._waiting = waiting

    def __await__(self) -> Generator[Any, Any, Outcome]:
        error: BaseException | None = None
        while True:
            try:
                awaited = self._coroutine.send(None) if error is None else self._coroutine.throw(error)
            except StopIteration as returned:
                return returned.value  # type: ignore[no-any-return] # checked by who awaits this
            if not self._waiting.is_given:
                error = RuntimeError("a modifier waits for its context and its child only")
                continue
            error = None
            try:
                yield awaited
            except BaseException as thrown:
                error = thrown


class _Context:
    """`ModifierContext` of one application."""

    def __init__(self, applied: Applied, place: Place, waiting: _Waiting) -> None:
        self._span = applied.plan.span
        self._place = place
        self._waiting = waiting

    @property
    def now(self) -> float:
        return self._place.agenda.now

    def log(self, message: str, level: str = "info") -> None:
        self._place.services.trace.log(message, level, self._span)

    async def sleep(self, duration: float) -> None:
        waiter = Waiter(self._place.flow)
        self._place.agenda.at(self.now + duration, waiter)
        await self._wait(waiter)

    async def hold(self) -> NoReturn:
        flow = self._place.flow
        flow.open_ended = True
        try:
            await self._wait(Waiter(flow))
        finally:
            flow.open_ended = False
        raise AssertionError("nothing fires this")

    async def _wait(self, waiter: Waiter) -> None:
        waits = self._place.services.waits
        waits[waiter.flow] = self._span
        try:
            with self._waiting.given():
                await self._place.agenda.wait(waiter)
        finally:
            del waits[waiter.flow]

    def allow_contact(self, entities: Sequence[str]) -> AbstractContextManager[None]:
        place = self._place
        return place.services.contacts.allow(place.position, None, frozenset(entities) or None)

    @contextmanager
    def forbid_contact(
        self, robots: Sequence[str], allowed: Sequence[str], interrupt: Interrupt, *, also_struck: bool
    ) -> Generator[None]:
        place = self._place
        services = place.services
        homes = services.homes.robots(robots)
        unobserved = [home for home in homes if not senses(home)]
        if unobserved:
            who = ", ".join(f"{home.name} of {home.backend.name}" for home in unobserved)
            reason = f"contacts cannot be forbidden: those of {who} are unobserved"
            services.decide(RunStatus.ERROR, reason, self._span)
        contacts, names = services.contacts, frozenset(allowed)
        with (
            contacts.allow(place.position, None, names),
            contacts.forbid(place.position, homes, interrupt.make, also_struck=also_struck),
        ):
            yield


async def _interruptible(place: Place, interrupt: Interrupt, behave: Callable[[], Awaitable[Outcome]]) -> Outcome:
    """Carry something out, and cancel it when an interrupt is made."""
    agenda = place.agenda
    with agenda.scope(place.flow) as scope:

        def end() -> None:
            if not agenda.is_ended(scope):
                agenda.end(scope, explained(Outcome(Status.CANCELLED, interrupt.reason), place, scope))

        interrupt.when_made(lambda: agenda.tell(lambda: agenda.after_round(place.position, end)))
        try:
            return await behave()
        except asyncio.CancelledError:
            if not agenda.left(scope):
                raise
            assert scope.outcome is not None, "it was ended"
            return scope.outcome
        finally:
            interrupt.when_made(None)


class _Child:
    """`Child` of one application."""

    def __init__(self, applied: Applied, place: Place, inner: Carry, waiting: _Waiting) -> None:
        self._span = applied.plan.span
        self._place = place
        self._inner = inner
        self._waiting = waiting
        self._runs = 0
        self.explanation: Explanation | None = None  # of what was cut off at its limit

    async def run(self, limit: float | None = None, interrupt: Interrupt | None = None) -> Outcome | None:
        place, agenda = self._place, self._place.agenda
        if place.flow.ended is not None:
            raise asyncio.CancelledError  # the modifier has not let itself be cancelled
        self._runs += 1
        place = place.again(self._runs)
        with self._waiting.given():
            if self._runs > 1:
                place.services.count_start(self._span, len(place.position))
                await agenda.step(place.flow)
            behave: Callable[[], Awaitable[Outcome]] = partial(self._inner, place)
            if interrupt is not None:
                behave = partial(_interruptible, place, interrupt, behave)
            began = time.monotonic()
            if limit is None:
                outcome, is_cut_off = await behave(), False
            else:
                outcome, is_cut_off = await within_limit(place, limit, behave)
            if interrupt is not None and interrupt.reason and outcome.status is Status.CANCELLED:
                self.explanation = outcome.explanation
                return None
            if not is_cut_off:
                return outcome
            if limit and (loss := place.services.homes.loss_since(began)):
                raise BackendLost(loss)
            self.explanation = outcome.explanation
            return None
