"""Subscriptions to event specifications (7.3.10.4), for `wait`, `until`, `on`, `sample` and coverage.

Events belong to an instance of a scenario or an action, a struct or an actor; those of a label to the last
invocation under it. A derived event (`event e is ...`) occurs for each subscription in the context of its use.
Where 7.3.10.4 is silent: a bare condition occurs at most once in an instant, like events.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeAlias, assert_never, cast

from seoro.lang import plan as plan_
from seoro.lang.plan import (
    DeclaredEvent,
    EventReference,
    EventSpecification,
    LabelEvent,
    MemberEvent,
    ObjectType,
    OnEvent,
    PhaseEvent,
)
from seoro.runtime.events.conditions import Conditions, EventContext, Stop
from seoro.runtime.events.declared import Events
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.instances.instances import Composed, Instance
from seoro.runtime.kernel.channel import Occurrence, OnReceive, Subscription
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.task import CausalPast
from seoro.runtime.values.environment import Environment, EvaluationError
from seoro.runtime.values.values import Actor, HasFields, Struct

NESTING = 64  # depth of derived events; those of one instance cannot be cyclic

EnvironmentOf: TypeAlias = Callable[[HasFields, Environment], Environment]
"""Returns the environment of an instance's scope, seen from another scope."""


class Subscriptions:
    """Connects subscriptions with channels and conditions.

    Args:
        scheduler: Scheduler of the run.
        events: Channels of the run.
        conditions: Conditions of the run.
        objects: Declarations of structs and actors, by type name.
        environment_of: Returns the environment of an instance's scope.
        failed: Called for an expression without a value, after which nothing more is received.
    """

    def __init__(
        self,
        scheduler: Scheduler,
        events: Events,
        conditions: Conditions,
        objects: Mapping[str, ObjectType],
        environment_of: EnvironmentOf,
        failed: Callable[[EvaluationError], None],
    ) -> None:
        self._scheduler = scheduler
        self._events = events
        self._conditions = conditions
        self._objects = objects
        self._environment_of = environment_of
        self._failed = failed
        self._depth = 0

    def connect_own(self, subscription: Subscription, specification: EventSpecification, holder: Instance) -> bool:
        """Connect a subscription directly with an event of an instance, if the specification is only that.

        This is the usual case; it needs no environment.

        Returns:
            Whether it is connected.
        """
        if (
            not isinstance(specification, OnEvent)
            or specification.condition is not None
            or specification.name is not None
        ):
            return False
        event = specification.event
        if isinstance(event, PhaseEvent):
            channel = self._events.phase(holder, event.label, event.phase)
        elif isinstance(event, DeclaredEvent) and holder.events[event.name].specification is None:
            channel = self._events.declared(holder, event.name)
        else:
            return False
        subscription.receive_from(channel)
        return True

    def listen(
        self,
        specification: EventSpecification,
        environment: Environment,
        context: EventContext,
        on_receive: OnReceive,
    ) -> Stop:
        """Call a function with each occurrence from this instant on, at commit; return the function that stops it.

        Args:
            specification: The event specification.
            environment: Environment of the specification; its instance has the events.
            context: Context of the subscription.
            on_receive: The function.

        Raises:
            EvaluationError: The path to the event has no value.
        """
        if not isinstance(specification, OnEvent):
            occurs = self._once_an_instant(on_receive)
            return self._conditions.arm(specification, environment, context, occurs)
        name = specification.name
        holds, forget = self._conditions.guard(specification.condition, environment, context, name)

        def receive(occurrence: Occurrence) -> bool:
            bound = {**environment.bindings, name: cast(HasFields, occurrence)} if name else environment.bindings
            return holds(replace(environment, bindings=bound)) and on_receive(occurrence)

        leave = self._attach(specification.event, environment, context, receive)

        def stop() -> None:
            leave()
            forget()

        return stop

    def _once_an_instant(self, on_receive: OnReceive) -> Callable[[], None]:
        last = -1

        def occurs() -> None:
            nonlocal last
            if last != self._scheduler.instant:
                last = self._scheduler.instant
                on_receive(Occurrence({}))

        return occurs

    def _attach(
        self, reference: EventReference, environment: Environment, context: EventContext, on_receive: OnReceive
    ) -> Stop:
        match reference:
            case DeclaredEvent() | PhaseEvent():
                return self._attach_own(reference, environment, context, on_receive)
            case MemberEvent(base, event):
                holder = cast(HasFields, evaluate(base, environment))
                return self._attach(event, self._environment_of(holder, environment), context, on_receive)
            case LabelEvent(label, event):
                return self._attach_labelled(label, event, environment, context, on_receive)
            case _:
                assert_never(reference)

    def _attach_own(
        self,
        reference: DeclaredEvent | PhaseEvent,
        environment: Environment,
        context: EventContext,
        on_receive: OnReceive,
    ) -> Stop:
        """Attach to an event of an instance: to its channel, and to its source if it is derived."""
        receiver = _Source(context.past, on_receive)
        holder = environment.instance
        if isinstance(reference, PhaseEvent):
            assert isinstance(holder, Instance | Composed), "checked: it has phases"
            channel = self._events.phase(holder, reference.label, reference.phase)
        else:
            assert isinstance(holder, Instance | Struct | Actor)
            channel = self._events.declared(holder, reference.name)
        channel.attach(receiver)

        def leave() -> None:
            channel.detach(receiver)

        specification = None if isinstance(reference, PhaseEvent) else self._specification(holder, reference.name)
        if specification is None:
            return leave
        if self._depth == NESTING:
            raise EvaluationError(f"derived events are nested more than {NESTING} deep", specification.span)
        self._depth += 1
        derive = self._events.derive
        forget = self.listen(specification, environment, context, lambda _: on_receive(derive(channel)))
        self._depth -= 1

        def stop() -> None:
            leave()
            forget()

        return stop

    def _specification(self, holder: HasFields, name: str) -> EventSpecification | None:
        """Return the source of a derived event, or None."""
        if isinstance(holder, Instance):
            return holder.events[name].specification
        assert isinstance(holder, Struct | Actor)
        declared = next(self._objects[type_] for type_ in holder.types if type_ in self._objects)
        found: plan_.Event = next(event for event in declared.events if event.name == name)
        return found.specification

    def _attach_labelled(
        self,
        label: str,
        event: EventReference,
        environment: Environment,
        context: EventContext,
        on_receive: OnReceive,
    ) -> Stop:
        """Attach to an event of the last and of future invocations under a label."""
        instance = environment.instance
        assert isinstance(instance, Instance), "checked: it has labels"
        latest = instance.latest(label)
        leave: Stop | None = None

        def rebind(invoked: Instance) -> None:
            nonlocal leave
            if leave is not None:
                leave()
            inside = self._environment_of(invoked, environment)
            try:
                leave = self._attach(event, inside, context, on_receive)
            except EvaluationError as error:
                self._failed(error)

        if latest.instance is not None:
            rebind(latest.instance)
        latest.on_change[rebind] = None

        def stop() -> None:
            del latest.on_change[rebind]
            if leave is not None:
                leave()

        return stop


class _Source:
    """Receiver that forwards occurrences.

    Args:
        past: Occurrences to ignore.
        deliver: Called with each occurrence; returns whether it counts.
    """

    __slots__ = ("deliver", "past")

    def __init__(self, past: CausalPast, deliver: OnReceive) -> None:
        self.past = past
        self.deliver = deliver
