"""Declarations of the plan: scenarios, actions, modifiers, and the plan itself."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from seoro.lang.frozen import Value
from seoro.lang.plan.behaviors import Behavior, InvokeAction, InvokeScenario, On, Sample, invocations_in
from seoro.lang.plan.coverage import Coverage
from seoro.lang.plan.events import EventSpecification
from seoro.lang.plan.expressions import Expression
from seoro.lang.plan.methods import Methods
from seoro.lang.plan.modifications import AppliedModifier
from seoro.lang.plan.structures import Constraint, Structure, Structures
from seoro.lang.plan.types import ActorType, ValueType
from seoro.lang.source import Span


class Event(Value):
    """An event of an instance.

    Args:
        name: Its name.
        parameters: The names of its parameters, with their defaults, evaluated by each emission that does not give
            a value (7.3.10.2).
        types: The types of its parameters, in the same order.
        specification: Specification that makes it occur without `emit`, in the scope of its instance; its event
            context starts at each use of the event (7.3.10.4).
    """

    name: str
    parameters: tuple[tuple[str, Expression | None], ...]
    types: tuple[ValueType, ...]
    specification: EventSpecification | None
    span: Span

    def all_arguments(self, given: tuple[tuple[str, Expression], ...]) -> dict[str, Expression]:
        """Return an expression for each parameter, from given values and defaults."""
        arguments = {name: default for name, default in self.parameters if default is not None}
        return {**arguments, **dict(given)}


class ObjectType(Value):
    """Reactions of a struct or an actor, including inherited ones."""

    name: str
    events: tuple[Event, ...]
    samples: tuple[Sample, ...]
    modifiers: tuple[AppliedModifier, ...]
    span: Span


class Declaration(Value):
    """Common members of scenarios, actions and modifiers, including inherited ones.

    Args:
        name: Its name.
        structure: Its parameters and the constraints on them.
        events: Its events.
        on: Its reactions to events, while it runs.
        samples: Its sampled variables.
        modifiers: The modifiers that it applies to each invocation, or to the modified behavior.
        span: Its name in the text.
    """

    name: str
    structure: Structure
    events: tuple[Event, ...]
    on: tuple[On, ...]
    samples: tuple[Sample, ...]
    modifiers: tuple[AppliedModifier, ...]
    span: Span


class Scenario(Declaration):
    """A scenario; `bases` are the names of its bases, nearest first."""

    bases: tuple[str, ...]
    body: Behavior | None


class Action(Declaration):
    """An action; `bases` are the names of its bases, nearest first, and `library` is its imported library."""

    bases: tuple[str, ...]
    actor: ActorType | None
    library: str | None


class Modifier(Declaration):
    """A modifier (7.3.12).

    In its expressions and constraints, the binding `actor` is the actor that it is applied to, and `it` the
    modified behavior.

    Args:
        actor: The type of actor that it belongs to.
        of: The scenario or action whose invocations it modifies; None for any behavior.
        library: Its imported library if it is atomic, which means implemented in Python; None for a compound one.
    """

    actor: ActorType | None
    of: str | None
    library: str | None


class Plan(Value):
    """A scenario with everything it can invoke, ready to run.

    Args:
        entry: The scenario to run, a key of `scenarios`.
        overrides: Constraints from outside on its fields and on global parameters; applied last.
        scenarios: The entry scenario and every scenario that can be invoked from it.
        actions: Every action that can be invoked.
        modifiers: Every modifier that is applied.
        objects: The structs and actors that have events, sampled variables or modifiers, by their names.
        globals: The global parameters (7.3.14), whose values are chosen with those of the entry scenario.
        structures: The structures of all structs and actors.
        methods: The methods of all types.
        file: The entry file, as the user named it.
        coverage: Sampled items, by the declaring type (7.5).
    """

    entry: str
    overrides: tuple[Constraint, ...]
    scenarios: Mapping[str, Scenario]
    actions: Mapping[str, Action]
    modifiers: Mapping[str, Modifier]
    objects: Mapping[str, ObjectType]
    globals: Structure
    structures: Structures
    methods: Methods
    file: str
    coverage: Coverage

    def object_type(self, types: Iterable[str]) -> ObjectType | None:
        """Return the reactions of a value with these types, nearest first; the nearest type has all of them."""
        return next((self.objects[name] for name in types if name in self.objects), None)

    def invocations(self) -> Iterator[InvokeAction | InvokeScenario]:
        """Yield all invocations in scenarios."""
        for scenario in self.scenarios.values():
            yield from invocations_in(scenario.body)

    def action_invocations(self) -> Iterator[InvokeAction]:
        """Yield all invocations of actions."""
        return (each for each in self.invocations() if isinstance(each, InvokeAction))

    def invoked(self, invocation: InvokeAction | InvokeScenario) -> Action | Scenario:
        """Return the declaration that an invocation invokes."""
        if isinstance(invocation, InvokeScenario):
            return self.scenarios[invocation.scenario]
        return self.actions[invocation.action]

    def is_bound(self, invocation: InvokeAction | InvokeScenario) -> bool:
        """Whether constraints affect the parameters of an invocation."""
        return bool(invocation.constraints) or not self.invoked(invocation).structure.is_plain
