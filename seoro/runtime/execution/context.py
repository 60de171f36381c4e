"""`ExecutionContext`: the context of a behavior: its task, scenario, position and name.

Explanations read the current activities from the `BehaviorScope` of each behavior.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Coroutine, Mapping
from copy import copy
from dataclasses import replace
from typing import Any, TypeAlias

from seoro.lang.plan import Behavior, Elapsed, EventSpecification, Literal
from seoro.lang.source import Span
from seoro.runtime.events.conditions import EventContext
from seoro.runtime.events.ticks import seconds
from seoro.runtime.execution.names import Location
from seoro.runtime.execution.services import Services
from seoro.runtime.instances.instances import Composed, Instance
from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.kernel.channel import OnReceive, Subscription
from seoro.runtime.kernel.clock import TIME_DIGITS
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.task import CausalPast, Task
from seoro.runtime.values.environment import Environment, Seed
from seoro.runtime.values.values import HasFields, Value
from seoro.runtime.verdict import Outcome


class ExecutionContext:
    """Context of a running behavior. Only `number` changes, when the behavior starts.

    Args:
        services: Services of the run.
        task: Task of the behavior.
        instance: Instance of the enclosing scenario.
        number: Trace number of the innermost behavior that has started here.
        position: Position in the tree of invocations.
        location: The same, as text.
        invoked: The invoked instance, for modifiers of an invocation or a composition and for the behavior itself.
        runs: Number of runs so far, for each modifier around it.
    """

    __slots__ = ("instance", "invoked", "location", "number", "position", "runs", "services", "task")

    def __init__(
        self,
        services: Services,
        task: Task,
        instance: Instance,
        number: int | None,
        position: tuple[int, ...],
        location: Location,
        invoked: Invoked | None = None,
        runs: tuple[int, ...] = (),
    ) -> None:
        self.services = services
        self.task = task
        self.instance = instance
        self.number = number
        self.position = position
        self.location = location
        self.invoked = invoked
        self.runs = runs

    def __copy__(self) -> ExecutionContext:
        # By hand, since each behavior copies several contexts: `copy.copy` alone takes several times as long.
        return ExecutionContext(
            self.services,
            self.task,
            self.instance,
            self.number,
            self.position,
            self.location,
            self.invoked,
            self.runs,
        )

    @property
    def path(self) -> str:
        """Its position, as text."""
        return self.location.text

    def purpose(self) -> str:
        """Return the purpose of random draws here: independent of step order, different in each repetition."""
        return f"{self.path} {'.'.join(map(str, self.runs)) if self.runs else ''}"

    def take_invoked(self) -> Instance:
        """Return the instance that an invocation runs here."""
        assert self.invoked is not None, "within an invocation"
        instance = self.invoked.take(self)
        assert isinstance(instance, Instance), "not a composition"
        return instance

    @property
    def scheduler(self) -> Scheduler:
        """The scheduler of the run."""
        return self.services.scheduler

    def explained(self, outcome: Outcome, scope: CancelScope) -> Outcome:
        """Add the explanation to an outcome: the current activities in a scope that the outcome is about to end.

        Args:
            outcome: The outcome; returned unchanged if it has an explanation.
            scope: A scope of this behavior.
        """
        if outcome.explanation is not None:
            return outcome
        explanation = self.services.explain(self.services, [scope.task, *scope.tasks], self.path, outcome.span)
        return replace(outcome, explanation=explanation)

    # -------------------------------------------------------- contexts around it

    def member(self, index: int, behavior: Behavior, task: Task | None = None) -> ExecutionContext:
        """Return the context of a member of this composition, or of this body.

        Args:
            index: Index of the member.
            behavior: The member.
            task: Its task; by default, the same task.
        """
        found = copy(self)
        found.position, found.location = (*self.position, index), Location(self.location, behavior, index)
        if task is not None:
            found.task = task
        return found

    def reaction(self, name: str, number: int) -> ExecutionContext:
        """Return the context of a reaction of this instance."""
        found = copy(self)
        found.position = (*self.position, number)
        found.location = Location.of(f"{self.path}/{name}[{number}]")
        return found

    def of_instance(self, instance: Instance) -> ExecutionContext:
        """Return the context inside an instance that runs here."""
        found = copy(self)
        found.instance, found.invoked = instance, None
        return found

    def of_modifier(self, instance: Instance, position: tuple[int, ...]) -> ExecutionContext:
        """Return the context of a modifier's instance, at a position below this one."""
        found = copy(self)
        found.position, found.location = (*self.position, *position), Location.of(instance.path)
        return found

    def invoking(self, invoked: Invoked | None) -> ExecutionContext:
        """Return this context with another invoked instance."""
        found = copy(self)
        found.invoked = invoked
        return found

    def run_again(self, run: int) -> ExecutionContext:
        """Return this context for one run of a modified behavior; the first run is 1."""
        found = copy(self)
        found.runs = (*self.runs, run)
        if run > 1:
            found.location = Location.of(f"{self.path}#{run}")
        return found

    def like(self, other: ExecutionContext) -> ExecutionContext:
        """Return this context with the name and the runs of another."""
        found = copy(self)
        found.location, found.runs = other.location, other.runs
        return found

    def inside(self, number: int) -> ExecutionContext:
        """Return this context within the behavior of a trace number."""
        found = copy(self)
        found.number = number
        return found

    # -------------------------------------------------------- names and events

    def environment(self, bindings: Mapping[str, Value | HasFields] | None = None) -> Environment:
        """Return the environment for expressions here; `it` is the invoked instance."""
        all_bindings = self.instance.bindings
        if bindings:
            all_bindings = {**bindings, **all_bindings}
        if self.invoked is not None:
            all_bindings = {**all_bindings, "it": self.invoked.instance}
        instance, seed = self.instance, Seed(self.services.seed, self.purpose())
        plan, run = self.services.plan, self.services.run
        return Environment(instance, plan, all_bindings, self.path, instance.around, seed=seed, run=run)

    def event_context(
        self, past: CausalPast | None = None, purpose: Callable[[], str] | None = None
    ) -> EventContext:
        """Return an event context that starts now.

        Args:
            past: Past of the subscriber; by default, that of the task.
            purpose: Purpose of its random draws; by default, as here.
        """
        past = self.task.past if past is None else past
        return EventContext(self.services.scheduler.now, past, self.position, purpose or self.purpose)

    def end_of(self, elapsed: Elapsed) -> float:
        """Return when a duration that starts now has elapsed [s]; durations from a range are drawn.

        Raises:
            EvaluationError: The duration is negative or has no value.
        """
        duration, services = elapsed.duration, self.services
        if isinstance(duration, Literal):  # the usual case; needs no environment
            return round(services.scheduler.now + seconds(duration.value, duration), TIME_DIGITS)
        return services.conditions.end_of(elapsed, self.environment(), self.event_context())

    def subscribe(
        self,
        event: EventSpecification,
        past: CausalPast | None = None,
        on_receive: OnReceive | None = None,
        purpose: Callable[[], str] | None = None,
    ) -> Subscription:
        """Return a subscription to one occurrence of an event specification, to be entered.

        Args:
            event: The specification.
            past: Occurrences to ignore; by default, the past of the task.
            on_receive: Called at commit with each occurrence, instead of `Subscription.receive`.
            purpose: Purpose of its random draws; by default, as here.

        Raises:
            EvaluationError: The path to the event has no value.
        """
        subscription = Subscription(self.task, past, on_receive, once=True)
        subscriptions = self.services.subscriptions
        if not subscriptions.connect_own(subscription, event, self.instance):
            context = self.event_context(past, purpose)
            subscription.on_close(subscriptions.listen(event, self.environment(), context, subscription.deliver))
        return subscription

    def waiting(self, span: Span) -> Waiting:
        """Return a block that notes the condition that the task waits for; a stuck run reports it."""
        return Waiting(self.services.waits, self.task, span)


class Waiting:
    """Block that notes the condition that a task waits for.

    Args:
            waits: Conditions of all tasks.
            task: The task.
            span: Text of the condition.
    """

    __slots__ = ("_span", "_task", "_waits")

    def __init__(self, waits: dict[Task, Span], task: Task, span: Span) -> None:
        self._waits = waits
        self._task = task
        self._span = span

    def __enter__(self) -> None:
        self._waits[self._task] = self._span

    def __exit__(self, *_: object) -> None:
        del self._waits[self._task]


class Invoked:
    """Instances of one invocation or composition, for its modifiers.

    Args:
        instance: The latest instance; modifiers see the first one before it runs.
        make: Creates another instance, for the next run in a context.
        depth: Depth of the scope of the invocation in its task.
        is_watched: Whether modifiers must see the next instance before it runs.
    """

    __slots__ = ("_is_taken", "_make", "depth", "instance", "is_watched")

    def __init__(
        self,
        instance: Instance | Composed,
        make: Callable[[ExecutionContext], Instance | Composed],
        depth: int,
        is_watched: bool = False,
    ) -> None:
        self.instance = instance
        self._make = make
        self.depth = depth
        self.is_watched = is_watched
        self._is_taken = False

    def renew(self, context: ExecutionContext) -> None:
        """Create another instance, if the latest has run."""
        if self._is_taken:
            self.instance, self._is_taken = self._make(context), False

    def take(self, context: ExecutionContext) -> Instance | Composed:
        """Return an instance that has not run yet."""
        self.renew(context)
        self._is_taken = True
        return self.instance


class BehaviorScope(CancelScope):
    """Scope of a behavior.

    Args:
        behavior: The behavior.
        context: Its context.
    """

    __slots__ = ("behavior", "context", "since")

    def __init__(self, behavior: Behavior, context: ExecutionContext) -> None:
        self.task = context.task  # without `super`, to save time for each behavior
        self.outcome = None
        self.behavior = behavior
        self.context = context
        self.since = context.services.scheduler.now  # [s]


def behaviors_of(task: Task) -> list[BehaviorScope]:
    """Return the running behaviors of a task, the innermost first."""
    found: list[BehaviorScope] = []
    scope = task.scope
    while scope is not None and scope.task is task:
        if isinstance(scope, BehaviorScope):
            found.append(scope)
        scope = scope.outer
    return found


Perform: TypeAlias = Callable[[Behavior, ExecutionContext], Awaitable[Outcome]]
"""Runs a behavior."""

PerformMember: TypeAlias = Callable[[Task, Behavior, int, ExecutionContext], Coroutine[Any, Any, Outcome]]
"""Runs a member of a composition in a task of its own, given its index and the composition's context."""

Carry: TypeAlias = Callable[[ExecutionContext], Awaitable[Outcome]]
"""Runs a certain behavior in a context."""
