"""What a behavior has around it while it is carried out: the run's services, its scenario, its place."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import count
from typing import TYPE_CHECKING, NamedTuple
from weakref import WeakSet, ref

from seoro.lang import frozen
from seoro.lang import plan as plan_
from seoro.lang.plan import (
    Action,
    Behavior,
    CallMethod,
    Emit,
    InvokeAction,
    InvokeScenario,
    Modifier,
    ObjectType,
    OneOf,
    Override,
    OwnEvent,
    Parallel,
    Phase,
    PhaseEvent,
    Plan,
    Sample,
    Scenario,
    Serial,
    Wait,
)
from seoro.lang.source import Span
from seoro.runtime.agenda import Agenda, Flow, Scope
from seoro.runtime.choose.fields import Fields
from seoro.runtime.choose.times import Window
from seoro.runtime.common import Common
from seoro.runtime.conditions import Conditions
from seoro.runtime.environment import Seed
from seoro.runtime.evaluate import Environment, EvaluationError, HasFields
from seoro.runtime.events import Event, Events
from seoro.runtime.explain import explain
from seoro.runtime.explanation import Explanation
from seoro.runtime.instantiate import types_of
from seoro.runtime.method_context import MethodContext
from seoro.runtime.trace import Trace
from seoro.runtime.values import Actor, Struct, Value, plain
from seoro.runtime.verdict import Cancelled, Outcome, RunStatus, Status

if TYPE_CHECKING:
    from seoro.runtime.actions import BoundAction
    from seoro.runtime.coverage import Coverage
    from seoro.runtime.homes import Homes
    from seoro.runtime.modifiers import BoundModifier

STARTS_PER_INSTANT = 200_000  # beyond this, a loop of steps that take no time
NESTING = 2_000  # of behaviors; beyond this, a scenario that invokes itself without end


class Decision(frozen.Value):
    """What ended the run, where the entry scenario's own end did not."""

    status: RunStatus
    reason: str
    span: Span | None
    explanation: Explanation | None = None


class Running(NamedTuple):
    """A behavior that is being carried out: where, and since when [s]."""

    behavior: Behavior
    place: Place
    since: float


@dataclass(eq=False)
class Services:
    """What all behaviors of a run share."""

    plan: Plan
    seed: int
    agenda: Agenda
    events: Events
    trace: Trace
    coverage: Coverage
    actions: Mapping[str, BoundAction]
    modifiers: Mapping[str, BoundModifier]
    run: MethodContext
    homes: Homes
    grace: float  # [s] of the machine's clock, for the clean-up of a cancelled action
    decision: Decision | None = None
    root: Flow | None = None
    fault: Exception | None = None  # what an action raised, or seoro itself, that ended the run
    entry: Invoked | None = None  # once the run has begun
    cancelled: list[Cancelled] = field(default_factory=list)  # what the end of the entry scenario has cancelled
    overriding: dict[Overriding, None] = field(default_factory=dict)  # what holds at present
    waits: dict[Flow, Span] = field(default_factory=dict)  # what flows wait for at present
    running: dict[Flow, list[Running]] = field(default_factory=dict)  # what flows are in, the innermost last
    emitted: dict[int, float] = field(default_factory=dict)  # when an `emit`, by its identity, was reached [s]
    held: WeakSet[Struct | Actor] = field(default_factory=WeakSet)  # whose sampled variables are sampled
    modified: WeakSet[Struct | Actor] = field(default_factory=WeakSet)  # whose modifiers are carried out
    _ids: count[int] = field(default_factory=count)
    _starts: int = 0
    _starts_instant: int = -1

    @property
    def is_ending(self) -> bool:
        """Whether what goes on is the end of the entry scenario, or of the run."""
        entry = self.entry.instance if self.entry is not None else None
        scope = entry.scope if isinstance(entry, Instance) else None
        return self.decision is not None or (scope is not None and self.agenda.is_ended(scope))

    def new_id(self) -> int:
        """A number for a behavior in the trace."""
        return next(self._ids)

    def random(self, purpose: str) -> random.Random:
        """A stream of random numbers of its own for each purpose, the same on any machine."""
        return random.Random(f"{self.seed}/{purpose}")  # noqa: S311 - reproducible, not secret

    @cached_property
    def common(self) -> Common:
        """What actions have in common."""
        return Common(self.agenda, self.trace, self.grace, self.decide)

    @cached_property
    def conditions(self) -> Conditions:
        """The armed conditions."""
        return Conditions(self.agenda, self.random, self.fail)

    def fail(self, error: EvaluationError) -> None:
        """End the run because an expression has no value."""
        self.decide(RunStatus.ERROR, str(error), error.span)

    def write(self, holder: HasFields, name: str, shown: str, place: Place, value: Callable[[], Value]) -> None:
        """Change a variable, between this round and the next (section 1 of the semantics).

        Args:
            holder: What has the variable as a field.
            name: The name of the field.
            shown: What people call the variable.
            place: Of what changes it.
            value: Gives the new value then.
        """

        by = place.parent

        def take_hold() -> None:
            changed = value()
            holder.fields[name] = changed  # type: ignore[index] # all holders have a dict
            self._record_change(holder, name, shown, changed, by)
            self.conditions.changed(holder, name)

        self.agenda.write(place.position, take_hold)

    def _record_change(self, holder: HasFields, name: str, shown: str, value: Value, by: int | None) -> None:
        trace = self.trace
        if trace.is_observed:
            fields = {"of": trace.exact.number(holder), "field": name, "exact": trace.exact.value(value), "by": by}
            trace.record("variable", path=shown, value=plain(value), **fields)

    def declared_event(self, holder: Instance | Struct | Actor, name: str) -> plan_.Event:
        """The declaration of an event of an instance."""
        if isinstance(holder, Instance):
            return holder.events[name]
        declared = self._declared(holder)
        assert declared is not None, "checked: it has the event"
        return next(event for event in declared.events if event.name == name)

    def samples_of(self, holder: Struct | Actor) -> tuple[Sample, ...]:
        """The variables of a struct or an actor that are sampled."""
        declared = self._declared(holder)
        return declared.samples if declared is not None else ()

    @cached_property
    def has_samples_in_objects(self) -> bool:
        """Whether any struct or actor has a sampled variable."""
        return any(declared.samples for declared in self.plan.objects.values())

    @cached_property
    def has_modified_objects(self) -> bool:
        """Whether any struct or actor has a modifier."""
        return any(declared.modifiers for declared in self.plan.objects.values())

    def _declared(self, holder: Struct | Actor) -> ObjectType | None:
        """What a struct or an actor has besides its fields; of its types, the nearest has all of it."""
        return next((self.plan.objects[name] for name in holder.types if name in self.plan.objects), None)

    def channel(self, holder: Instance | Struct | Actor, name: str) -> Event:
        """The channel of a declared event of an instance."""
        return holder.declared(name) if isinstance(holder, Instance) else self.events.of_object(holder, name)

    def environment_of(self, holder: HasFields, around: Environment) -> Environment:
        """What names stand for in the scope of an instance, seen from another scope."""
        if not isinstance(holder, Instance):
            return replace(around, instance=holder, bindings={}, scenario=around.outermost)
        seed = Seed(self.seed, holder.path)
        return Environment(holder, holder.bindings, holder.path, holder.around, seed=seed, run=self.run)

    def count_start(self, span: Span, depth: int) -> None:
        """Count a start of a behavior.

        Raises:
            EvaluationError: There are so many in this instant that it will never settle, or so many nested in
                one another that a scenario must invoke itself without end.
        """
        if depth > NESTING:
            raise EvaluationError(f"more than {NESTING} behaviors are nested in one another", span)
        if self._starts_instant != self.agenda.instant:
            self._starts_instant, self._starts = self.agenda.instant, 0
        self._starts += 1
        if self._starts > STARTS_PER_INSTANT:
            raise EvaluationError(
                f"instantaneous loop: more than {STARTS_PER_INSTANT:,} behaviors started without time passing",
                span,
            )

    def decide(self, status: RunStatus, reason: str, span: Span | None) -> None:
        """End the run, between this round and the next; the first to say so decides."""
        if self.decision is None:
            self.decision = Decision(status, reason, span)
            outcome = Outcome(Status.FAILED if status is RunStatus.FAILED else Status.CANCELLED, reason, span)
            self.agenda.after_round((), partial(self._end_run, outcome))

    def break_off(self, defect: Exception) -> None:
        """End the run as an error because of a defect of seoro's own, whatever was decided before."""
        if self.fault is None:
            self.fault = defect
        reason = f"internal error: {type(defect).__name__}: {defect}"
        self.decide(RunStatus.ERROR, reason, None)
        self.decision = Decision(RunStatus.ERROR, reason, None)

    def _end_run(self, outcome: Outcome) -> None:
        if self.root is not None and self.decision is not None:
            try:
                explanation = explain(self, self.root.scopes[0], "", self.decision.span)
                self.decision = replace(self.decision, explanation=explanation)
            finally:
                self.agenda.end_flow(self.root, outcome)


@dataclass(eq=False)
class Latest:
    """What was invoked last under a label.

    Args:
        instance: The instance; None before the first invocation.
        told: Called between rounds with the next one.
    """

    instance: Instance | None = None
    told: dict[Callable[[Instance], None], None] = field(default_factory=dict)

    def take(self, instance: Instance) -> None:
        """There is a new instance."""
        self.instance = instance
        for turn_to in tuple(self.told):
            turn_to(instance)


@dataclass(eq=False)
class _WithPhases:
    """What starts and ends.

    Args:
        path: Its position, for people.
        fields: Values of its parameters.
    """

    path: str
    fields: Fields
    windows: Mapping[str, Window] = field(default_factory=dict, kw_only=True)  # of its times

    @cached_property
    def _phases(self) -> dict[tuple[str | None, Phase], Event]:
        return {}

    def phase(self, label: str | None, phase: Phase) -> Event:
        """The channel of a predefined event: of a labelled member, or of this itself."""
        found = self._phases.get((label, phase))
        if found is None:
            name = f"{label}.{phase.value}" if label else phase.value
            found = self._phases[label, phase] = Event(f"{self.path}.{name}", ref(self), name)
        return found


@dataclass(eq=False)
class Composed(_WithPhases):
    """A composition while it is carried out, for its `with:` block; its fields are its parameters."""

    types: tuple[str, ...] = ()

    def is_heard(self, phase: Phase) -> bool:
        """Whether anyone has listened to one of its events."""
        return (None, phase) in self._phases


@dataclass(eq=False)
class Instance(_WithPhases):
    """A running scenario or action, or a modifier of one.

    Args:
        path, fields: As for all that starts and ends.
        declaration: What runs.
        bindings: What names are bound in its scope besides its fields: `actor`, and `it` in a modifier.
        around: The scenario in which a modifier is applied, which has the global parameters; None for all else.
    """

    declaration: Scenario | Action | Modifier
    bindings: Mapping[str, Value | HasFields]
    around: HasFields | None = None
    scope: Scope | None = None  # from the start of its execution

    @property
    def actor(self) -> Actor | None:
        """The actor that a scenario or an action was invoked on, if it belongs to one."""
        actor = self.bindings.get("actor")
        assert actor is None or isinstance(actor, Actor), "asked of what is invoked"
        return actor

    @cached_property
    def types(self) -> tuple[str, ...]:
        """What `plan.Methods` calls its type and what that inherits, nearest first."""
        return types_of(self.declaration)

    @property
    def reacts(self) -> bool:
        """Whether it does anything by itself, as nearly no action does."""
        declared = self.declaration
        return bool(declared.on or declared.samples)

    @cached_property
    def events(self) -> dict[str, plan_.Event]:
        """The declarations of its events, by their names."""
        return {event.name: event for event in self.declaration.events}

    @cached_property
    def _declared(self) -> dict[str, Event]:
        return {name: Event(f"{self.path}.{name}", ref(self), name) for name in self.events}

    @cached_property
    def running(self) -> dict[str, Scope]:
        """What runs at present under labels."""
        return {}

    @cached_property
    def _latest(self) -> dict[str, Latest]:
        return {}

    def latest(self, label: str) -> Latest:
        """What was invoked last under a label."""
        return self._latest.setdefault(label, Latest())

    def invoked(self, label: str) -> Instance | None:
        """What was invoked last under a label; None before the first time."""
        return self.latest(label).instance

    def declared(self, name: str) -> Event:
        """The channel of an event that it declares."""
        return self._declared[name]

    def event(self, reference: OwnEvent) -> Event:
        """The channel of an event of this scenario or action."""
        if isinstance(reference, PhaseEvent):
            return self.phase(reference.label, reference.phase)
        return self.declared(reference.name)


@dataclass(eq=False, slots=True)
class Invoked:
    """The instances of one invocation, or what stands for one composition, for what modifies it.

    Args:
        instance: The latest; what modifies the invocation sees the first before that is carried out.
        make: Makes another one, for when it is carried out again at a place.
        depth: Of the scope of the invocation in its flow.
        is_watched: Whether what modifies it has to see the next one before that is carried out.
    """

    instance: Instance | Composed
    make: Callable[[Place], Instance | Composed]
    depth: int
    is_watched: bool = False
    _is_taken: bool = False

    def renew(self, place: Place) -> None:
        """It is going to be carried out again, by another instance."""
        if self._is_taken:
            self.instance, self._is_taken = self.make(place), False

    def take(self, place: Place) -> Instance | Composed:
        """One that has not been carried out."""
        self.renew(place)
        self._is_taken = True
        return self.instance


class Overriding(frozen.Frozen):
    """`override` while it holds.

    Args:
        plan: What it says.
        instance: The scenario that has its labels.
    """

    plan: Override
    instance: Instance


@dataclass(eq=False, slots=True)
class Place:
    """Where a behavior is carried out; never changed, but not frozen, since each behavior gets several.

    Args:
        services: Of the run.
        flow: The flow of control.
        instance: The scenario that contains it.
        parent: Number, in the trace, of the behavior around it.
        position: Its position in the tree of invocations.
        path: The same, for people.
        invoked: For what modifies an invocation or a composition, and for what carries it out: what that is.
        runs: How many times each modifier around it has started what it modifies.
    """

    services: Services
    flow: Flow
    instance: Instance
    parent: int | None
    position: tuple[int, ...]
    path: str
    invoked: Invoked | None = None
    runs: tuple[int, ...] = ()

    @property
    def purpose(self) -> str:
        """Names what is drawn here: the same in any order of steps, another in each repetition."""
        return f"{self.path} {'.'.join(map(str, self.runs)) if self.runs else ''}"

    def take_invoked(self) -> Instance:
        """What is carried out here by an invocation."""
        assert self.invoked is not None, "an invocation stands here"
        instance = self.invoked.take(self)
        assert isinstance(instance, Instance), "it is no composition"
        return instance

    @property
    def agenda(self) -> Agenda:
        """The agenda of the run."""
        return self.services.agenda

    def within(self, flow: Flow) -> Place:
        """The same, in a flow that was forked for it."""
        return Place(
            self.services, flow, self.instance, self.parent, self.position, self.path, self.invoked, self.runs
        )

    def member(self, index: int, behavior: Behavior) -> Place:
        """The place of a member of what stands here."""
        position, path = (*self.position, index), f"{self.path}/{name_of(behavior)}[{index}]"
        return Place(self.services, self.flow, self.instance, self.parent, position, path, self.invoked, self.runs)

    def invoking(self, invoked: Invoked | None) -> Place:
        """The same, where something is invoked."""
        return Place(
            self.services, self.flow, self.instance, self.parent, self.position, self.path, invoked, self.runs
        )

    def again(self, run: int) -> Place:
        """The same, in one of the runs of what a modifier there modifies; the first is 1."""
        path, runs = self.path if run == 1 else f"{self.path}#{run}", (*self.runs, run)
        return Place(self.services, self.flow, self.instance, self.parent, self.position, path, self.invoked, runs)

    def inside(self, number: int) -> Place:
        """The same, within the behavior that has a number in the trace."""
        return Place(
            self.services, self.flow, self.instance, number, self.position, self.path, self.invoked, self.runs
        )

    def environment(self, bindings: Mapping[str, Value | HasFields] | None = None) -> Environment:
        """What names stand for here; in what modifies an invocation, `it` is what is invoked."""
        all_bindings = self.instance.bindings
        if bindings:
            all_bindings = {**bindings, **all_bindings}
        if self.invoked is not None:
            all_bindings = {**all_bindings, "it": self.invoked.instance}
        instance, seed = self.instance, Seed(self.services.seed, self.purpose)
        return Environment(instance, all_bindings, self.path, instance.around, seed=seed, run=self.services.run)


_KINDS: Mapping[type[Behavior], str] = {
    Serial: "serial",
    Parallel: "parallel",
    OneOf: "one_of",
    Wait: "wait",
    Emit: "emit",
    CallMethod: "call",
    InvokeAction: "action",
    InvokeScenario: "scenario",
}


def type_of(behavior: Behavior) -> str:
    """The kind of a behavior, as the trace calls it."""
    return _KINDS[type(behavior)]


def name_of(behavior: Behavior) -> str:
    """What people call a behavior: its label, else what it invokes as the scenario writes it, else its kind."""
    if behavior.label:
        return behavior.label
    match behavior:
        case InvokeAction(action=name, actor=actor) | InvokeScenario(scenario=name, actor=actor):
            return name if actor is None else f"{actor.span.text}.{name.rpartition('.')[2]}"
        case _:
            return type_of(behavior)
