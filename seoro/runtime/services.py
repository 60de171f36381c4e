"""What all behaviors of a run share: its parts, what is going on, and what has decided it."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import count
from typing import TYPE_CHECKING, NamedTuple
from weakref import WeakSet

from seoro.lang import frozen
from seoro.lang import plan as plan_
from seoro.lang.plan import (
    Behavior,
    ObjectType,
    Override,
    Plan,
    Sample,
)
from seoro.lang.source import Span
from seoro.runtime.agenda import Agenda, Flow
from seoro.runtime.common import Common
from seoro.runtime.conditions import Conditions
from seoro.runtime.contacts import Contacts
from seoro.runtime.endless import EndlessInstants
from seoro.runtime.environment import Seed
from seoro.runtime.evaluate import Environment, EvaluationError, HasFields
from seoro.runtime.events import Event, Events
from seoro.runtime.explain import explain
from seoro.runtime.explanation import Explanation
from seoro.runtime.instances import Instance, Invoked
from seoro.runtime.method_context import MethodContext
from seoro.runtime.trace import Trace
from seoro.runtime.values import Actor, Struct, Value, plain
from seoro.runtime.verdict import Cancelled, Outcome, RunStatus, Status

if TYPE_CHECKING:
    from seoro.runtime.actions import BoundAction
    from seoro.runtime.coverage import Coverage
    from seoro.runtime.homes import Homes
    from seoro.runtime.modifiers import BoundModifier
    from seoro.runtime.place import Place


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


class Overriding(frozen.Frozen):
    """`override` while it holds.

    Args:
        plan: What it says.
        instance: The scenario that has its labels.
    """

    plan: Override
    instance: Instance


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
    def contacts(self) -> Contacts:
        """The contacts of robots."""
        return Contacts(self._warn)

    def _warn(self, message: str) -> None:
        self.trace.log(message, "warning", self.plan.scenarios[self.plan.entry].span)

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
        self._endless.count(self.agenda.instant, span)

    @cached_property
    def _endless(self) -> EndlessInstants:
        return EndlessInstants(partial(self.decide, RunStatus.ERROR))

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
