"""Reactions of a running instance: `on`, sampled variables, coverage
(7.6.2.5.5, 7.3.6.1.2, 7.5).

Their event contexts start with the scenario or action; for a variable of a struct or an actor, with the scenario
that held it first. Each reacts to every occurrence, in the next delta cycle of the same instant: it takes a step
like a task, but has no task. Each has a past of its own, so that it does not receive its own emissions. The last
event that it reacts to is the `end` or `fail` of the instance; an instance cancelled from outside drops pending
reactions.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from functools import partial

from seoro.lang.plan import CallMethod, Emit, EventSpecification, On, OnEvent, OwnEvent, Sample
from seoro.runtime.behaviors.call import run_call
from seoro.runtime.behaviors.emit import run_emit
from seoro.runtime.behaviors.records import record_end, record_start
from seoro.runtime.execution.context import ExecutionContext
from seoro.runtime.execution.services import Writer
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.instances.instances import newly_held
from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.kernel.channel import Occurrence
from seoro.runtime.kernel.task import CausalPast
from seoro.runtime.values.environment import Environment, EvaluationError
from seoro.runtime.values.values import HasFields, Value
from seoro.runtime.verdict import CANCELLED

_Answer = Callable[[Environment, CausalPast], None]


class Reactions:
    """The started reactions of an instance.

    Args:
        context: Context within the instance.
        scope: Scope of its execution.
        armed: Receives the callbacks that stop the reactions.
    """

    def __init__(self, context: ExecutionContext, scope: CancelScope, armed: ExitStack) -> None:
        self._context = context
        self._scope = scope
        self._armed = armed
        self._number = 0
        self._abandoned = 0  # number of calls of `abandon`
        instance = context.instance
        for sample in instance.declaration.samples:
            self._sample(sample, instance, sample.field)
        if context.services.has_samples_in_objects:
            for holder, path in newly_held(instance, context.services.held):
                for sample in context.services.samples_of(holder):
                    self._sample(sample, holder, f"{path}.{sample.field}")
        for directive in instance.declaration.on:
            self._on(directive)
        if context.services.coverage is not None:
            context.services.coverage.watch(instance, self._observe)

    def abandon(self) -> None:
        """Drop pending reactions of an instance that was cancelled."""
        self._abandoned += 1

    def _on(self, directive: On) -> None:
        """Start an `on` directive, which runs its members in order."""
        inside = self._next_context("on")

        def answer(environment: Environment, past: CausalPast) -> None:
            for number, member in enumerate(directive.members):
                _carry_out(member, inside.member(number, member), environment, past)

        self._arm(directive.event, self._context.environment(), inside, answer)

    def _sample(self, sample: Sample, holder: HasFields, shown: str) -> None:
        """Start sampling a variable."""
        inside = self._next_context("sample")

        def answer(environment: Environment, past: CausalPast) -> None:
            inside.services.count_start(sample.span, 0)
            value = evaluate(sample.value, environment)
            writer = Writer(inside.position, inside.number, past.cause)
            inside.services.write(holder, sample.field, shown, writer, lambda: value)

        environment = self._context.environment()
        if holder is not self._context.instance:
            environment = inside.services.environment_of(holder, environment)
        self._arm(sample.event, environment, inside, answer)

    def _observe(self, source: HasFields, event: OwnEvent, notify: Callable[[], None]) -> None:
        """Call `notify` at commit for each occurrence of an event of the instance, or of an object that it holds.

        The observer has an empty past, so it receives all occurrences."""

        def meet(_: Occurrence) -> bool:
            notify()
            return True

        context = self._next_context("coverage")
        around = context.environment()
        inside = around if source is context.instance else context.services.environment_of(source, around)
        specification = OnEvent(event, None, None, event.span)
        event_context = context.event_context(CausalPast())
        self._armed.callback(context.services.subscriptions.listen(specification, inside, event_context, meet))

    def _next_context(self, name: str) -> ExecutionContext:
        """Return the context of the next reaction; the body is member 0."""
        self._number += 1
        return self._context.reaction(name, self._number)

    def _arm(
        self, event: EventSpecification, environment: Environment, inside: ExecutionContext, answer: _Answer
    ) -> None:
        past = inside.task.past.fork()
        name = event.name if isinstance(event, OnEvent) else None

        def meet(occurrence: Occurrence) -> bool:
            bound: dict[str, Value | HasFields] = {name: occurrence} if name is not None else {}
            there = environment.bind(**bound)
            take = partial(_answer_to, inside.scheduler.cause, past, partial(answer, there, past))
            react = partial(self._react, inside, self._abandoned, take)
            inside.scheduler.react(inside.position, react)
            return True

        event_context = inside.event_context(past)
        self._armed.callback(inside.services.subscriptions.listen(event, environment, event_context, meet))

    def _react(self, inside: ExecutionContext, abandoned: int, answer: Callable[[], None]) -> None:
        """Take the step, unless the instance has ended."""
        if abandoned < self._abandoned or self._scope.is_cancelled:
            return
        try:
            answer()
        except EvaluationError as error:
            inside.services.fail(error)


def _answer_to(cause: int | None, past: CausalPast, answer: Callable[[], None]) -> None:
    past.cause = cause
    answer()


def _carry_out(
    member: Emit | CallMethod, context: ExecutionContext, environment: Environment, past: CausalPast
) -> None:
    context.services.count_start(member.span, len(context.position))
    number = record_start(member, context, past)
    outcome = CANCELLED  # unless it has a value
    try:
        if isinstance(member, Emit):
            outcome = run_emit(member, context, environment, past)
        else:
            outcome = run_call(member, environment)
    finally:
        record_end(number, outcome, context.services, past)
