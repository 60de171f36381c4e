"""What an instance does by itself while it runs: `on`, sampled variables, coverage
(7.6.2.5.5, 7.3.6.1.2, 7.5).

Their event contexts start with the execution of the scenario or action; of a variable in a struct or an actor,
with that of the scenario that held it first. Each reacts to every occurrence, in the next round of the same
instant: it takes a step as flows do, but has no flow. Each has a past of its own, so that what it emits does not
reach it again. The `end` or `fail` of the instance is the last that it reacts to; what is ended from outside
reacts to nothing else any more.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from functools import partial

from seoro.lang.plan import CallMethod, Emit, EventSpecification, On, OnEvent, OwnEvent, Sample
from seoro.runtime.agenda import Scope
from seoro.runtime.behaviors.call import run_call
from seoro.runtime.behaviors.emit import run_emit
from seoro.runtime.behaviors.records import record_end, record_start
from seoro.runtime.conditions import Context
from seoro.runtime.environment import Environment, EvaluationError
from seoro.runtime.evaluate import evaluate
from seoro.runtime.events import Occurrence
from seoro.runtime.holding import newly_held
from seoro.runtime.listening import Listener
from seoro.runtime.past import Past
from seoro.runtime.place import Place
from seoro.runtime.values import HasFields, Value
from seoro.runtime.verdict import CANCELLED

_Answer = Callable[[Environment, Past], None]


def arm_reactions(place: Place, scope: Scope, armed: ExitStack) -> Reactions:
    """Let an instance react from now on.

    Args:
        place: Within the instance.
        scope: Of its execution.
        armed: At its end, nothing occurs any more that has to be reacted to.
    """
    reactions = Reactions(place, scope, armed)
    instance = place.instance
    for sample in instance.declaration.samples:
        reactions.sample(sample, instance, sample.field)
    if place.services.has_samples_in_objects:
        for holder, path in newly_held(instance, place.services.held):
            for sample in place.services.samples_of(holder):
                reactions.sample(sample, holder, f"{path}.{sample.field}")
    for directive in instance.declaration.on:
        reactions.on(directive)
    place.services.coverage.watch(instance, reactions.observe)
    return reactions


class Reactions:
    """The reactions of an instance; the arguments are those of `arm_reactions`."""

    def __init__(self, place: Place, scope: Scope, armed: ExitStack) -> None:
        self._place = place
        self._scope = scope
        self._armed = armed
        self._number = 0
        self._abandoned = 0  # how many times

    def abandon(self) -> None:
        """The instance was ended from outside: what it has not reacted to is lost."""
        self._abandoned += 1

    def on(self, directive: On) -> None:
        """`on`: its members in their order."""
        inside = self._next_place("on")

        def answer(environment: Environment, past: Past) -> None:
            for number, member in enumerate(directive.members):
                _carry_out(member, inside.member(number, member), environment, past)

        self._arm(directive.event, self._place.environment(), inside, answer)

    def sample(self, sample: Sample, holder: HasFields, shown: str) -> None:
        """A sampled variable takes its value."""
        inside = self._next_place("sample")

        def answer(environment: Environment, past: Past) -> None:
            inside.services.count_start(sample.span, 0)
            value = evaluate(sample.value, environment)
            inside.services.write(holder, sample.field, shown, inside, lambda: value)

        environment = self._place.environment()
        if holder is not self._place.instance:
            environment = inside.services.environment_of(holder, environment)
        self._arm(sample.event, environment, inside, answer)

    def observe(self, source: HasFields, event: OwnEvent, tell: Callable[[], None]) -> None:
        """Tell of each occurrence of an event of the instance, or of what it holds, when it takes hold; nothing is
        in the past of who looks on."""

        def meet(_: Occurrence) -> bool:
            tell()
            return True

        place = self._next_place("coverage")
        listener = Listener(place.services, _context(place, Past()))
        around = place.environment()
        inside = around if source is place.instance else place.services.environment_of(source, around)
        self._armed.callback(listener.listen(OnEvent(event, None, None, event.span), inside, meet))

    def _next_place(self, name: str) -> Place:
        """The place of the next reaction, after the body, which is member 0."""
        self._number += 1
        place = self._place
        path = f"{place.path}/{name}[{self._number}]"
        return replace(place, position=(*place.position, self._number), path=path)

    def _arm(self, event: EventSpecification, environment: Environment, inside: Place, answer: _Answer) -> None:
        past = inside.flow.past.fork()
        name = event.name if isinstance(event, OnEvent) else None

        def meet(occurrence: Occurrence) -> bool:
            bound: dict[str, Value | HasFields] = {name: occurrence} if name is not None else {}
            there = replace(environment, bindings={**environment.bindings, **bound})
            react = partial(self._react, inside, self._abandoned, partial(answer, there, past))
            inside.agenda.react(inside.position, react)
            return True

        self._armed.callback(Listener(inside.services, _context(inside, past)).listen(event, environment, meet))

    def _react(self, inside: Place, abandoned: int, answer: Callable[[], None]) -> None:
        """Take the step, unless the instance was ended before."""
        if abandoned < self._abandoned or inside.agenda.is_ended(self._scope):
            return
        try:
            answer()
        except EvaluationError as error:
            inside.services.fail(error)


def _context(place: Place, past: Past) -> Context:
    return Context(place.agenda.now, past, place.position, place.purpose)


def _carry_out(member: Emit | CallMethod, place: Place, environment: Environment, past: Past) -> None:
    place.services.count_start(member.span, len(place.position))
    number = record_start(member, place)
    outcome = CANCELLED  # unless it has a value
    try:
        if isinstance(member, Emit):
            outcome = run_emit(member, place, environment, past)
        else:
            outcome = run_call(member, environment)
    finally:
        record_end(number, outcome, place)
