"""Listening for event specifications (7.3.10.4): what `wait`, `until`, `on` and `sample` have in common.

Events belong to an instance of a scenario or an action, a struct or an actor; those of a label, to what was
invoked last under it. A derived event (`event e is ...`) occurs for each who listens to it in a context of its
own, that of the use. Where 7.3.10.4 is silent: a condition alone occurs at most once in an instant, as events do.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, TypeAlias, assert_never, cast

from seoro.lang.plan import (
    DeclaredEvent,
    EventReference,
    EventSpecification,
    LabelEvent,
    MemberEvent,
    OnEvent,
    PhaseEvent,
)
from seoro.runtime.conditions import Context, Stop
from seoro.runtime.environment import Environment, EvaluationError
from seoro.runtime.evaluate import evaluate
from seoro.runtime.events import Ear, Occurrence
from seoro.runtime.instances import Composed, Instance
from seoro.runtime.values import Actor, HasFields, Struct
from seoro.runtime.verdict import RunStatus

if TYPE_CHECKING:
    from seoro.runtime.services import Services

Meet: TypeAlias = Callable[[Occurrence], bool]  # says whether the occurrence counts

NESTING = 64  # of events that are derived from one another; those of one instance cannot be in a circle


class Listener:
    """Listens in one event context, until it is stopped.

    Args:
        services: Of the run.
        context: The event context.
    """

    def __init__(self, services: Services, context: Context) -> None:
        self._services = services
        self._context = context
        self._depth = 0

    def listen(self, specification: EventSpecification, environment: Environment, meet: Meet) -> Stop:
        """Call `meet` with each occurrence from now on; also with what has occurred in this instant already.

        Args:
            specification: What is listened for.
            environment: What names stand for in it; its instance has the events.
            meet: Called with each occurrence.

        Raises:
            EvaluationError: The path to the event has no value.
        """
        if not isinstance(specification, OnEvent):
            occurs = self._once_an_instant(meet)
            return self._services.conditions.arm(specification, environment, self._context, occurs)
        name = specification.name
        conditions = self._services.conditions
        holds, forget = conditions.guard(specification.condition, environment, self._context, name)

        def hear(occurrence: Occurrence) -> bool:
            bound = {**environment.bindings, name: cast(HasFields, occurrence)} if name else environment.bindings
            return holds(replace(environment, bindings=bound)) and meet(occurrence)

        leave = self._listen_to(specification.event, environment, hear)

        def stop() -> None:
            leave()
            forget()

        return stop

    def _once_an_instant(self, meet: Meet) -> Callable[[], None]:
        last = -1

        def occurs() -> None:
            nonlocal last
            if last != self._services.agenda.instant:
                last = self._services.agenda.instant
                meet(Occurrence(-1, {}))

        return occurs

    def _listen_to(self, reference: EventReference, environment: Environment, meet: Meet) -> Stop:
        match reference:
            case DeclaredEvent(name):
                return self._listen_declared(name, environment, meet)
            case PhaseEvent(label, phase):
                instance = environment.instance
                assert isinstance(instance, Instance | Composed), "checked: it has phases"
                ear = Ear(self._context.past, meet)
                self._services.events.listen(instance.phase(label, phase), ear)
                return ear.stop
            case MemberEvent(base, event):
                holder = cast(HasFields, evaluate(base, environment))
                return self._listen_to(event, self._services.environment_of(holder, environment), meet)
            case LabelEvent(label, event):
                return self._listen_labelled(label, event, environment, meet)
            case _:
                assert_never(reference)

    def _listen_declared(self, name: str, environment: Environment, meet: Meet) -> Stop:
        """Listen to an event of an instance: to what is emitted, and to what it is derived from."""
        services, holder = self._services, environment.instance
        assert isinstance(holder, Instance | Struct | Actor)
        channel = services.channel(holder, name)
        ear = Ear(self._context.past, meet)
        services.events.listen(channel, ear)
        specification = services.declared_event(holder, name).specification
        if specification is None:
            return ear.stop
        if self._depth == NESTING:
            raise EvaluationError(f"more than {NESTING} events are derived from one another", specification.span)
        self._depth += 1
        forget = self.listen(specification, environment, lambda _: meet(services.events.derive(channel)))
        self._depth -= 1

        def stop() -> None:
            ear.stop()
            forget()

        return stop

    def _listen_labelled(self, label: str, event: EventReference, environment: Environment, meet: Meet) -> Stop:
        """Listen to an event of what was invoked last under a label, and of what will be."""
        instance = environment.instance
        assert isinstance(instance, Instance), "checked: it has labels"
        latest = instance.latest(label)
        leave: Stop | None = None

        def turn_to(invoked: Instance) -> None:
            nonlocal leave
            if leave is not None:
                leave()
            inside = self._services.environment_of(invoked, environment)
            try:
                leave = self._listen_to(event, inside, meet)
            except EvaluationError as error:
                self._services.decide(RunStatus.ERROR, str(error), error.span)

        if latest.instance is not None:
            turn_to(latest.instance)
        latest.told[turn_to] = None

        def stop() -> None:
            del latest.told[turn_to]
            if leave is not None:
                leave()

        return stop
