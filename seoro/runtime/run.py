"""A run: from plan to trace and verdict.

`Execution` instantiates a plan, runs it on a clock, and ends with a `Verdict` on every path. `stop`, the loss of a
backend, or a cancellation of its task cancel the run from outside; running behaviors then clean up first.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Awaitable, Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from seoro.errors import BackendStopped
from seoro.lang.plan import InvokeScenario, Plan
from seoro.runtime.actions.needs import check_implementations, check_needs
from seoro.runtime.behaviors.perform import carry_scenario, lasting, recorded, within
from seoro.runtime.behaviors.records import record_instance
from seoro.runtime.contracts.backends import CONTACT, DEPARTURE, EXHAUSTED, WARNING, Backend
from seoro.runtime.events.declared import Events
from seoro.runtime.execution.assignment import ActorAssignment
from seoro.runtime.execution.context import ExecutionContext, Invoked
from seoro.runtime.execution.ending import end_backends
from seoro.runtime.execution.names import Location
from seoro.runtime.execution.outputs import OutputFile, Outputs
from seoro.runtime.execution.services import Decision, Services
from seoro.runtime.execution.settings import Settings
from seoro.runtime.execution.static_tree import static_tree
from seoro.runtime.execution.tracking import start_tracking
from seoro.runtime.instances.applied import with_nested
from seoro.runtime.instances.instances import Instance
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.task import Task
from seoro.runtime.parameters.parameters import entry_parameters, make_entry
from seoro.runtime.trace.records import Trace, write_error_text
from seoro.runtime.values.environment import MethodContext
from seoro.runtime.values.text import value_text
from seoro.runtime.values.values import Actor, Fields, plain
from seoro.runtime.verdict import Outcome, RunStatus, Verdict

if TYPE_CHECKING:
    from seoro.lang.source import Span
    from seoro.runtime.coverage.sampling import Coverage
    from seoro.runtime.execution.application import Application
    from seoro.runtime.explanation import Explanation

_ENTRY = 0  # trace number of the entry behavior


class Execution:
    """One run of a plan. Create it inside the event loop.

    Raises:
        UsageError: The plan cannot be run with these settings; nothing has started.
    """

    def __init__(self, plan: Plan, settings: Settings) -> None:
        self._plan = plan
        self._settings = settings
        self._scheduler = Scheduler(
            settings.clock, self._stuck, self.fail_backend, self._broken, settings.step_order
        )
        self._trace = Trace(settings.observers, lambda: self._scheduler.now, self._observer_failed)
        self._homes = ActorAssignment(settings.backends, settings.placements)
        self._run = self._method_context()
        self._coverage = self._cover() if plan.coverage else None
        self._entry = self._instantiate()
        self._application = self.application if settings.external or settings.recorded else None
        self.parameters = self._parameters()
        self.scenario = plan.entry
        self.verdict: Verdict | None = None  # set at the end of the run
        self._has_started = False
        self._tree = static_tree(plan) if settings.observers else None
        self._services = Services(
            plan=plan,
            seed=settings.seed,
            scheduler=self._scheduler,
            events=Events(self._scheduler, self._trace),
            trace=self._trace,
            coverage=self._coverage,
            actions=settings.actions,
            modifiers=settings.modifiers,
            run=self._run,
            homes=self._homes,
            grace=settings.grace,
            places=self._tree.places if self._tree is not None else {},
            explain=_explain,
            debugger=settings.debugger,
        )
        if settings.debugger is not None:
            self._scheduler.together = 1  # a task that pauses holds up the others of its delta cycle
            settings.debugger.begin(self._services)

    def _method_context(self) -> MethodContext:
        settings = self._settings
        return MethodContext(settings.seed, Path(self._plan.file), settings.output_directory, settings.locate)

    def _cover(self) -> Coverage:
        from seoro.runtime.coverage.sampling import Coverage  # noqa: PLC0415 - for plans with items

        return Coverage(self._plan, self._trace, self._method_context())

    def _parameters(self) -> dict[str, object]:
        """Return the initial values of all global parameters and all fields of the entry scenario."""
        fields = self._entry.fields
        names = (*self._plan.globals.fields, *self._entry.declaration.structure.fields)
        return {name: plain(fields[name]) for name in names}

    @property
    def parameter_texts(self) -> dict[str, str]:
        """Current values of global parameters and of the entry scenario, as written in the language."""
        declared = {**self._plan.globals.fields, **self._entry.declaration.structure.fields}
        fields, structures = self._entry.fields, self._plan.structures
        return {name: value_text(fields[name], field.type, structures) for name, field in declared.items()}

    @property
    def now(self) -> float:
        """Time on the run's clock [s]; callable from any thread."""
        return self._settings.clock.now() if self._has_started else 0.0

    @property
    def substitutions(self) -> dict[str, str]:
        """Robots of actors with another name, except for placements."""
        return self._homes.substitutions()

    @property
    def has_clock_failed(self) -> bool:
        """Whether time stands still because the simulator is lost or hangs."""
        return self._scheduler.has_clock_failed

    @property
    def fault(self) -> Exception | None:
        """Exception of an action's code or of seoro that ended the run, or None."""
        return self._services.fault

    @property
    def files(self) -> tuple[OutputFile, ...]:
        """Output files of actions, in order."""
        return tuple(self._services.common.shared(Outputs).files)

    def _instantiate(self) -> Instance:
        check_implementations(self._plan, self._settings.actions, self._settings.modifiers)
        entry, self._modifying = make_entry(self._plan, self._settings.seed, self._run)
        for value in entry.fields.values():
            if isinstance(value, Actor):
                self._homes.assign(value)
        self._homes.check()
        check_needs(self._plan, entry, self._settings.actions, self._homes)
        return entry

    def _entry_again(self, context: ExecutionContext) -> Instance:
        """Create another instance of the entry scenario, with the same values, for modifiers that repeat it."""
        self._services.cancelled.clear()
        entry = Instance(context.path, Fields(), self._entry.declaration, {})
        modifiers = tuple(with_nested(self._modifying))
        for applied in modifiers:
            applied.rebind(entry)
        entry_parameters(self._plan, self._settings.seed, self._run, entry, modifiers)
        record_instance(entry, _ENTRY, self._services)
        return entry

    @cached_property
    def application(self) -> Application:
        """Connection with the embedding program."""
        from seoro.runtime.execution.application import Application  # noqa: PLC0415 - most runs do without

        return Application(self._plan, self._entry, self._settings)

    # -------------------------------------------------------- ending from outside

    def stop(self, reason: str) -> None:
        """Cancel the run; it ends as cancelled after its clean-up. For tasks of the same event loop."""
        self._services.decide(RunStatus.CANCELLED, reason, None)
        self._scheduler.cut_grace()

    def _on_event(self, backend: Backend, name: str, arguments: Mapping[str, Any]) -> None:
        """Take an event of a backend into the present instant, or into the next."""
        self._scheduler.act_in_instant(partial(self._act_on_event, backend, name, arguments))

    def _act_on_event(self, backend: Backend, name: str, arguments: Mapping[str, Any]) -> None:
        """Record an event of a backend, which is the cause of its effects."""
        if name == WARNING:
            self._trace.log(arguments["message"], "warning", self._entry.declaration.span)
            return
        scheduler, services = self._scheduler, self._services
        scheduler.cause = self._trace.event(name, arguments)
        if name == CONTACT:
            services.contacts.report(backend, arguments)
        elif name in (DEPARTURE, EXHAUSTED):
            services.decide(RunStatus.FAILED, arguments["reason"], None)
        scheduler.cause = None

    def fail_backend(self, error: Exception) -> None:
        """End the run because a backend is lost, or was stopped by a person, which is not an error."""
        status = RunStatus.CANCELLED if isinstance(error, BackendStopped) else RunStatus.ERROR
        self._services.decide(status, str(error), None)
        self._scheduler.cut_grace()

    def _stuck(self) -> None:
        waits = list(self._services.waits.values())
        what = ", ".join(f"`{span.text.strip()}` ({span})" for span in waits) or "an external answer"
        reason = f"nothing can happen any more; still waiting for: {what}"
        self._services.decide(RunStatus.FAILED, reason, waits[0] if waits else None)

    def _observer_failed(self, error: Exception) -> None:
        self._services.decide(RunStatus.ERROR, write_error_text(error), None)

    def _broken(self, error: Exception) -> None:
        self._services.abort(error)
        # Tasks that the defect has blocked would be awaited forever.
        asyncio.get_running_loop().call_later(self._settings.grace, self._scheduler.abort)

    # -------------------------------------------------------- the run

    async def run(self) -> Verdict:
        """Run to the end, and return the verdict. Call it in a task without cancel scopes of anyio around.

        Such scopes cancel repeatedly, at every await, which would interrupt clean-ups.

        Raises:
            asyncio.CancelledError: The caller's task was cancelled; the run has stopped and cleaned up.
        """
        try:
            return await self._run_to_end()
        finally:
            if self._application is not None:
                self._application.end()

    async def _run_to_end(self) -> Verdict:
        wall_start = time.monotonic()
        beginning = self._record_start()
        scheduler, settings = self._scheduler, self._settings
        root = self._services.root = scheduler.start_root(self._perform_entry)
        root.past.cause = beginning
        cancelled = False
        for backend in settings.backends:
            await backend.start_run(partial(self._on_event, backend), self.fail_backend)
        rates = settings.pose_rate, settings.scan_rate
        await start_tracking(settings.backends, *rates, scheduler, self._trace)
        settings.clock.start()
        self._has_started = True
        self._services.common.share.begin()
        try:
            await scheduler.run(self._stop_with_task, self._settings.grace, self._services.common.end)
        except asyncio.CancelledError:
            cancelled = True
        if self._settings.backends:
            await end_backends(self._settings.backends, self._settings.grace)
        verdict = self.verdict = self._conclude(time.monotonic() - wall_start)
        if self._application is not None:
            self._application.end()
        self._record_end(verdict)  # leaving the block may raise
        if cancelled:
            raise asyncio.CancelledError
        return verdict

    def _stop_with_task(self) -> None:
        self.stop("its task was cancelled")  # no effect after the end of the run

    async def _perform_entry(self, root: Task) -> Outcome:
        services, entry = self._services, self._entry
        invoked = services.entry = Invoked(entry, self._entry_again, root.depth + 1)
        if self._application is not None:
            self._application.begin(services)
        context = ExecutionContext(services, root, entry, None, (), Location.of(entry.declaration.name), invoked)
        invocation = InvokeScenario(None, None, (), (), None, (), entry.declaration.span, self._plan.entry)
        modified = within(self._modifying, lasting(context, carry_scenario))

        def carry(inside: ExecutionContext) -> Awaitable[Outcome]:
            record_instance(entry, _ENTRY, services)
            return modified(inside)

        return await recorded(invocation, context, carry)

    # -------------------------------------------------------- results

    def _record_start(self) -> int | None:
        return self._trace.record(
            "run.start",
            scenario=self._plan.entry,
            file=self._plan.file,
            seed=self._settings.seed,
            parameters=self.parameters,
            overrides=dict(self._settings.overrides),
            **({"constraints": list(self._settings.constraints)} if self._settings.constraints else {}),
            **({"requirements": list(self._settings.requirements)} if self._settings.requirements else {}),
            clock=self._settings.clock.name,
            **({"rate": self._settings.rate} if math.isfinite(self._settings.rate) else {}),
            version=self._settings.version,
            **(self._tree.fields(self._settings.sources) if self._tree is not None else {}),
            **({"external": list(self._application.external)} if self._application is not None else {}),
            **({"robots": self._settings.named_robots} if self._settings.placements else {}),
        )

    def _conclude(self, wall_duration: float) -> Verdict:
        services = self._services
        decision = services.decision or self._decision()
        return Verdict(
            status=decision.status,
            reason=decision.reason,
            span=decision.span,
            duration=self._scheduler.now,
            wall_duration=wall_duration,
            seed=self._settings.seed,
            scenario=self._plan.entry,
            file=self._plan.file,
            cancelled=tuple(services.cancelled),
            coverage=self._coverage.results() if self._coverage is not None else (),
            logs=self._trace.last_logs,
            unobserved=tuple(services.unobserved),
            explanation=decision.explanation,
            margin=services.margins.least,
            requirements=tuple(self._settings.requirements),
        )

    def _decision(self) -> Decision:
        """Return the decision by the outcome of the entry scenario."""
        root = self._services.root
        outcome: Outcome | None = root.outcome if root is not None else None
        assert outcome is not None, "the root task has ended by itself"
        status = RunStatus.FAILED if outcome.failed else RunStatus.PASSED
        return Decision(status, outcome.reason, outcome.span, outcome.explanation)

    def _record_end(self, verdict: Verdict) -> None:
        self._trace.record(
            "run.end",
            self._services.root.past.cause if self._services.root is not None else None,
            status=verdict.status.value,
            reason=verdict.reason,
            source=str(verdict.span) if verdict.span else "",
            explanation=verdict.explanation.plain() if verdict.explanation else None,
            duration=verdict.duration,
            **({"margin": verdict.margin} if verdict.margin is not None else {}),
            **({"unobserved": list(verdict.unobserved)} if verdict.unobserved else {}),
            # In whole tenths of seconds, so that traces depend less on the load of the machine.
            cancelled=[each.plain() | {"clean_up": int(each.clean_up * 10) / 10} for each in verdict.cancelled],
        )


def _explain(services: Services, tasks: Sequence[Task], path: str, failed: Span | None) -> Explanation:
    from seoro.runtime.explain.explain import explain  # noqa: PLC0415 - for runs in which something fails

    return explain(services, tasks, path, failed)
