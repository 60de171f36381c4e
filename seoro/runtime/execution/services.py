"""Services shared by all behaviors of a run, with its current state and decision."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property, partial
from itertools import count
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeAlias
from weakref import WeakSet

from seoro.deferred import dataclass
from seoro.lang import frozen
from seoro.lang.plan import Override, Plan, Sample
from seoro.lang.source import Span
from seoro.runtime.events.conditions import Conditions
from seoro.runtime.events.declared import Events
from seoro.runtime.events.subscriptions import Subscriptions
from seoro.runtime.execution.loops import EndlessInstants
from seoro.runtime.execution.margins import Margins
from seoro.runtime.execution.resources import RunResources
from seoro.runtime.instances.instances import Composed, Instance
from seoro.runtime.kernel.cancel_scope import cancel_task
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.task import Scope, Task
from seoro.runtime.trace.records import Trace
from seoro.runtime.values.environment import Environment, EvaluationError, MethodContext, Seed
from seoro.runtime.values.values import Actor, HasFields, Struct, Value, plain
from seoro.runtime.verdict import Cancelled, RunStatus

if TYPE_CHECKING:
    from seoro.runtime.coverage.sampling import Coverage
    from seoro.runtime.execution.assignment import ActorAssignment
    from seoro.runtime.execution.contacts import Contacts
    from seoro.runtime.explanation import Explanation
    from seoro.runtime.functions.actions import BoundAction
    from seoro.runtime.functions.modifiers import BoundModifier


Explain: TypeAlias = "Callable[[Services, Sequence[Task], str, Span | None], Explanation]"

NESTING = 2_000  # maximum depth of behaviors; detects scenarios that invoke themselves endlessly


class Decision(frozen.Value):
    """Decision that ended the run, other than the end of the entry scenario."""

    status: RunStatus
    reason: str
    span: Span | None
    explanation: Explanation | None = None


class Writer(NamedTuple):
    """Behavior or reaction that changes a variable.

    Args:
        position: Its position in the tree of invocations.
        number: Its trace number.
        cause: Number of the record that brought about the change.
    """

    position: tuple[int, ...]
    number: int | None
    cause: int | None


class Debugging(Protocol):
    """Control of a run that may pause at the starts and ends of behaviors."""

    def begin(self, services: Services) -> None:
        """Note the services of the run, before its first step."""

    async def before(self, scope: Scope) -> None:
        """Return when the behavior that starts in a scope may continue."""

    async def after(self, scope: Scope) -> None:
        """Return when the run may continue after the behavior of a scope."""

    def release(self) -> None:
        """Continue without further pauses: the run ends."""


class Overriding(frozen.Frozen):
    """An active `override`.

    Args:
        plan: Its plan.
        instance: Scenario instance with its labels.
    """

    plan: Override
    instance: Instance


class Entry(Protocol):
    """Invocation of the entry scenario."""

    @property
    def instance(self) -> Instance | Composed:
        """Latest instance."""


@dataclass(eq=False)
class Services:
    """Services shared by all behaviors of a run."""

    plan: Plan
    seed: int
    scheduler: Scheduler
    events: Events
    trace: Trace
    coverage: Coverage | None  # None without coverage items in the plan
    actions: Mapping[str, BoundAction]
    modifiers: Mapping[str, BoundModifier]
    run: MethodContext
    homes: ActorAssignment
    grace: float  # [s] of the machine's clock, for the clean-up of a cancelled action
    places: Mapping[int, Mapping[str, Any]]  # of behaviors in the static tree, by identity; see `StaticTree`
    explain: Explain  # describes the current activities of tasks
    debugger: Debugging | None = None
    decision: Decision | None = None
    root: Task | None = None
    fault: Exception | None = None  # exception of an action or of seoro that ended the run
    entry: Entry | None = None  # once the run has begun
    cancelled: list[Cancelled] = field(default_factory=list)  # by the end of the entry scenario
    overriding: dict[Overriding, None] = field(default_factory=dict)  # currently active
    open_ended: set[Task] = field(default_factory=set)  # tasks that run an open-ended behavior
    waits: dict[Task, Span] = field(default_factory=dict)  # current conditions of waiting tasks
    emitted: dict[int, float] = field(default_factory=dict)  # last time [s] of each `emit`, by its identity
    held: WeakSet[Struct | Actor] = field(default_factory=WeakSet)  # with active sampled variables
    unobserved: dict[str, None] = field(default_factory=dict)  # moved robots whose contacts are not reported
    modified: WeakSet[Struct | Actor] = field(default_factory=WeakSet)  # with active modifiers
    _ids: count[int] = field(default_factory=count)

    @property
    def is_ending(self) -> bool:
        """Whether the entry scenario or the run is ending."""
        entry = self.entry.instance if self.entry is not None else None
        scope = entry.scope if isinstance(entry, Instance) else None
        return self.decision is not None or (scope is not None and scope.is_cancelled)

    def covers(self, instance: Instance) -> bool:
        """Whether an instance, or an object that it is the first to hold, has coverage items."""
        return self.coverage is not None and self.coverage.concerns(instance)

    def new_id(self) -> int:
        """Return a trace number for a behavior."""
        return next(self._ids)

    def random(self, purpose: str) -> random.Random:
        """Return a stream of random numbers for a purpose, the same on any machine."""
        return random.Random(f"{self.seed}/{purpose}")  # noqa: S311 - reproducible, not secret

    @cached_property
    def margins(self) -> Margins:
        """Margins of checks."""
        return Margins(self.trace)

    @cached_property
    def common(self) -> RunResources:
        """Resources shared by actions."""
        return RunResources(self.scheduler, self.trace, self.grace, self.decide)

    @cached_property
    def contacts(self) -> Contacts:
        """Contacts of robots."""
        from seoro.runtime.execution.contacts import Contacts  # noqa: PLC0415 - for runs with robots that move

        return Contacts(self.unobserved, self._warn)

    def _warn(self, message: str) -> None:
        self.trace.log(message, "warning", self.plan.scenarios[self.plan.entry].span)

    @cached_property
    def conditions(self) -> Conditions:
        """Armed conditions."""
        return Conditions(self.scheduler, self.random, self.fail)

    @cached_property
    def subscriptions(self) -> Subscriptions:
        """Connections of subscriptions with event sources."""
        return Subscriptions(
            self.scheduler, self.events, self.conditions, self.plan.objects, self.environment_of, self.fail
        )

    def fail(self, error: EvaluationError) -> None:
        """End the run as an error because an expression has no value."""
        self.decide(RunStatus.ERROR, str(error), error.span)

    def write(
        self,
        holder: HasFields,
        name: str,
        shown: str,
        writer: Writer,
        value: Callable[[], Value],
    ) -> None:
        """Change a variable, between this delta cycle and the next (section 1 of the semantics).

        Args:
            holder: Object with the variable as a field.
            name: Name of the field.
            shown: Name of the variable in the trace.
            writer: Behavior or reaction that changes it.
            value: Computes the new value at commit.
        """

        def commit() -> None:
            changed = value()
            holder.fields[name] = changed  # type: ignore[index] # all holders have a dict
            self.scheduler.cause = self._record_change(holder, name, shown, changed, writer)
            self.conditions.changed(holder, name)

        self.scheduler.write(writer.position, commit)

    def _record_change(self, holder: HasFields, name: str, shown: str, value: Value, writer: Writer) -> int | None:
        """Record a change of a variable; return the number of the record."""
        trace = self.trace
        if not trace.is_observed:
            return None
        fields = {"of": trace.exact.number(holder), "field": name, "exact": trace.exact.value(value)}
        return trace.record("variable", writer.cause, path=shown, value=plain(value), **fields, by=writer.number)

    def samples_of(self, holder: Struct | Actor) -> tuple[Sample, ...]:
        """Return the sampled variables of a struct or an actor."""
        declared = self.plan.object_type(holder.types)
        return declared.samples if declared is not None else ()

    @cached_property
    def has_samples_in_objects(self) -> bool:
        """Whether any struct or actor has a sampled variable."""
        return any(declared.samples for declared in self.plan.objects.values())

    @cached_property
    def has_modified_objects(self) -> bool:
        """Whether any struct or actor has a modifier."""
        return any(declared.modifiers for declared in self.plan.objects.values())

    def environment_of(self, holder: HasFields, around: Environment) -> Environment:
        """Return the environment of an instance's scope, seen from another scope."""
        if not isinstance(holder, Instance):
            return replace(around, instance=holder, bindings={}, scenario=around.outermost)
        seed = Seed(self.seed, holder.path)
        return Environment(holder, self.plan, holder.bindings, holder.path, holder.around, seed=seed, run=self.run)

    def count_start(self, span: Span, depth: int) -> None:
        """Count the start of a behavior.

        Raises:
            EvaluationError: Too many behaviors started in this instant, or are nested: the scenario loops or
                invokes itself endlessly.
        """
        if depth > NESTING:
            raise EvaluationError(f"behaviors are nested more than {NESTING} deep", span)
        self._endless.count(self.scheduler.instant, span)

    @cached_property
    def _endless(self) -> EndlessInstants:
        return EndlessInstants(partial(self.decide, RunStatus.ERROR))

    def decide(self, status: RunStatus, reason: str, span: Span | None) -> None:
        """End the run, between this delta cycle and the next; the first call decides."""
        if self.decision is None:
            self.decision = Decision(status, reason, span)
            if self.debugger is not None:
                self.debugger.release()
            self.scheduler.at_commit((), self._end_run)

    def abort(self, defect: Exception) -> None:
        """End the run as an error because of a defect in seoro, replacing an earlier decision."""
        if self.fault is None:
            self.fault = defect
        reason = f"internal error: {type(defect).__name__}: {defect}"
        self.decide(RunStatus.ERROR, reason, None)
        self.decision = Decision(RunStatus.ERROR, reason, None)

    def _end_run(self) -> None:
        if self.root is not None and self.decision is not None:
            try:
                tasks = [self.root, *self.root.descendants()]
                explanation = self.explain(self, tasks, "", self.decision.span)
                self.decision = replace(self.decision, explanation=explanation)
            finally:
                cancel_task(self.root)
