"""A run: from plan to trace and verdict.

`Execution` instantiates a plan, runs it on a clock, and ends with a `Verdict` on every path. It is cancelled from
outside in three ways: `stop`, the loss of a backend, or a cancellation of the task that runs it; in each, what was
started is cleaned up first.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Mapping, Sequence
from contextlib import suppress
from dataclasses import field
from functools import partial
from pathlib import Path
from typing import Any

import anyio

from seoro.errors import BackendError, BackendStopped, InvalidUse
from seoro.lang.frozen import Value
from seoro.lang.plan import InvokeScenario, Plan
from seoro.located import Locate, as_named
from seoro.runtime.actions import BoundAction
from seoro.runtime.agenda import Agenda, Flow, StepOrder
from seoro.runtime.applied import with_nested
from seoro.runtime.behaviors.perform import carry_scenario, lasting, recorded, within
from seoro.runtime.behaviors.records import record_instance
from seoro.runtime.choose.fields import Fields
from seoro.runtime.contacts import EVENT as CONTACT
from seoro.runtime.contracts import DEPARTURE, WARNING, Backend, Clock, Observer
from seoro.runtime.coverage import Coverage
from seoro.runtime.entry import make_entry
from seoro.runtime.events import Events
from seoro.runtime.homes import Homes, Placement
from seoro.runtime.instances import Instance, Invoked
from seoro.runtime.instantiate import entry_parameters
from seoro.runtime.invocations import invocations
from seoro.runtime.method_context import MethodContext
from seoro.runtime.modifiers import BoundModifier
from seoro.runtime.needs import check_needs
from seoro.runtime.outputs import OutputFile, Outputs
from seoro.runtime.place import Place
from seoro.runtime.services import Decision, Services
from seoro.runtime.trace import Trace, unwritten
from seoro.runtime.value_text import value_text
from seoro.runtime.values import Actor, plain
from seoro.runtime.verdict import Outcome, RunStatus, Verdict

_ENTRY = 0  # the number of the behavior that is the run itself


class Settings(Value):
    """How to run a plan.

    Args:
        seed: Of everything that is drawn.
        clock: The run's clock.
        backends: Where actors may live; opened, and closed after the run, by the caller.
        placements: Where actors live for whom that was chosen from outside, by their names.
        observers: Who sees the trace.
        actions: The actions that Python functions carry out, by qualified name.
        modifiers: The modifiers that they carry out, likewise.
        output_directory: Where the results of the run go; methods of libraries may ask for it.
        locate: Gives the places of files that are named by absolute paths.
        overrides: What was set from outside, by path, as expressions of the language; they stand in the trace.
        grace: Time for the clean-up of a cancelled action [s], on the machine's clock.
        version: Of seoro; stands in the trace.
        step_order: The order of steps in a round, as `Agenda` takes it; for tests that it changes nothing.
    """

    seed: int
    clock: Clock
    backends: Sequence[Backend] = ()
    placements: Mapping[str, Placement] = field(default_factory=dict)
    observers: Sequence[Observer] = ()
    actions: Mapping[str, BoundAction] = field(default_factory=dict)
    modifiers: Mapping[str, BoundModifier] = field(default_factory=dict)
    output_directory: Path | None = None
    locate: Locate = as_named
    overrides: Mapping[str, str] = field(default_factory=dict)
    grace: float = 5.0
    version: str = ""
    step_order: StepOrder | None = None


class Execution:
    """One run of a plan. Make it inside of the event loop.

    Raises:
        InvalidUse: The plan cannot be run with these settings; nothing has happened yet.
    """

    def __init__(self, plan: Plan, settings: Settings) -> None:
        self._plan = plan
        self._settings = settings
        self._done = anyio.Event()
        self._agenda = Agenda(settings.clock, self._stuck, self.fail_backend, self._broken, settings.step_order)
        self._trace = Trace(settings.observers, lambda: self._agenda.now, self._observer_failed)
        self._homes = Homes(settings.backends, settings.placements)
        self._actions = settings.actions
        self._run, run_of_coverage = (
            MethodContext(settings.seed, Path(plan.file), settings.output_directory, settings.locate)
            for _ in range(2)
        )
        self._coverage = Coverage(plan.coverage, self._trace, run_of_coverage)
        self._entry = self._instantiate()
        self.parameters = self._parameters()
        self.scenario = plan.entry
        self.verdict: Verdict | None = None  # once the run is over
        self._has_started = False
        self._services = Services(
            plan=plan,
            seed=settings.seed,
            agenda=self._agenda,
            events=Events(self._agenda, self._trace.occurrence),
            trace=self._trace,
            coverage=self._coverage,
            actions=self._actions,
            modifiers=settings.modifiers,
            run=self._run,
            homes=self._homes,
            grace=settings.grace,
        )

    def _parameters(self) -> dict[str, object]:
        """The chosen value of every global parameter, and of every field of the entry scenario, before the run."""
        fields = self._entry.fields
        names = (*self._plan.globals.fields, *self._entry.declaration.structure.fields)
        return {name: plain(fields[name]) for name in names}

    @property
    def parameter_texts(self) -> dict[str, str]:
        """The present values of global parameters and of the entry scenario, as the language writes them."""
        declared = {**self._plan.globals.fields, **self._entry.declaration.structure.fields}
        fields, structures = self._entry.fields, self._plan.structures
        return {name: value_text(fields[name], field.type, structures) for name, field in declared.items()}

    @property
    def now(self) -> float:
        """The time on the run's clock [s], for any thread."""
        return self._settings.clock.now() if self._has_started else 0.0

    @property
    def substitutions(self) -> dict[str, str]:
        """Names of homes by the actors that live in one of another name without being placed there."""
        return self._homes.substitutions()

    @property
    def has_clock_failed(self) -> bool:
        """Whether time stands still, because the simulator is gone or hangs."""
        return self._agenda.has_clock_failed

    @property
    def fault(self) -> Exception | None:
        """The exception of an action's own code, or of seoro itself, that ended the run, if one did."""
        return self._services.fault

    @property
    def files(self) -> tuple[OutputFile, ...]:
        """The files that actions have left in the output folder, in order."""
        return tuple(self._services.common.shared(Outputs).files)

    def _instantiate(self) -> Instance:
        _check_implementations(self._plan, self._settings)
        entry, self._modifying = make_entry(self._plan, self._settings.seed, self._run)
        for value in entry.fields.values():
            if isinstance(value, Actor):
                self._homes.settle(value)
        self._homes.check()
        check_needs(self._plan, entry, self._actions, self._homes)
        return entry

    def _entry_again(self, place: Place) -> Instance:
        """For modifiers of the entry scenario that carry it out again; its values are the same."""
        self._services.cancelled.clear()
        entry = Instance(place.path, Fields(), self._entry.declaration, {})
        modifiers = tuple(with_nested(self._modifying))
        for applied in modifiers:
            applied.turn_to(entry)
        entry_parameters(self._plan, self._settings.seed, self._run, entry, modifiers)
        record_instance(entry, _ENTRY, self._services)
        return entry

    # -------------------------------------------------------- ending from outside

    def stop(self, reason: str) -> None:
        """Cancel the run; it cleans up, and ends as cancelled. For any task of the same event loop."""
        self._services.decide(RunStatus.CANCELLED, reason, None)
        self._agenda.hurry()

    def _tell(self, backend: Backend, name: str, arguments: Mapping[str, Any]) -> None:
        """Record what a backend says of its own accord."""
        if name == CONTACT:
            self._services.contacts.tell(backend, arguments)
        if name == WARNING:
            source = self._entry.declaration.span
            self._agenda.tell(partial(self._trace.log, arguments["message"], "warning", source))
        else:
            self._agenda.tell(partial(self._trace.event, name, arguments))
        if name == DEPARTURE:
            self._agenda.tell(partial(self._services.decide, RunStatus.FAILED, arguments["reason"], None))

    def fail_backend(self, error: Exception) -> None:
        """End the run because a backend is gone, or somebody has stopped it, which is no error."""
        status = RunStatus.CANCELLED if isinstance(error, BackendStopped) else RunStatus.ERROR
        self._services.decide(status, str(error), None)
        self._agenda.hurry()

    def _stuck(self) -> None:
        waits = list(self._services.waits.values())
        what = ", ".join(f"`{span.text.strip()}` ({span})" for span in waits) or "an answer that nobody will give"
        reason = f"nothing can happen any more; this still waits: {what}"
        self._services.decide(RunStatus.FAILED, reason, waits[0] if waits else None)

    def _observer_failed(self, error: Exception) -> None:
        self._services.decide(RunStatus.ERROR, unwritten(error), None)

    def _broken(self, error: Exception) -> None:
        self._services.break_off(error)
        # What the defect has kept from going on would be waited for without end.
        asyncio.get_running_loop().call_later(self._settings.grace, self._done.set)

    # -------------------------------------------------------- the run

    async def run(self) -> Verdict:
        """Run to the end.

        Raises:
            asyncio.CancelledError: The caller's task was cancelled; the run has been stopped and cleaned up.
        """
        wall_start = time.monotonic()
        self._record_start()
        agenda = self._agenda
        root = self._services.root = agenda.fork((), None, self._perform_entry)
        root.on_end = lambda flow: self._done.set()
        cancelled = False
        async with anyio.create_task_group() as watch:
            watch.start_soon(self._stop_when_cancelled)
            with anyio.CancelScope(shield=True):
                for backend in self._settings.backends:
                    await backend.start_run(partial(self._tell, backend), self.fail_backend)
                self._settings.clock.start()
                self._has_started = True
                async with anyio.create_task_group() as group:
                    self._services.common.begin(group)
                    group.start_soon(agenda.drive)
                    while not self._done.is_set() and not group.cancel_scope.cancel_called:
                        try:
                            await self._done.wait()
                        except asyncio.CancelledError:
                            cancelled = True
                            self.stop("its task was cancelled")
                    agenda.finish()
                    await self._services.common.end()
                await self._abandon(root)
                await self._end_backends()
            verdict = self.verdict = self._conclude(time.monotonic() - wall_start)
            watch.cancel_scope.cancel()
        self._record_end(verdict)
        if cancelled:
            raise asyncio.CancelledError
        return verdict

    async def _abandon(self, root: Flow) -> None:
        """Cancel what is left of a run that a defect of seoro's own has ended; of any other, nothing is."""
        for flow in reversed((root, *root.scopes[0].flows)):
            if flow.task is not None and flow.alive:
                flow.task.cancel()
                await asyncio.wait({flow.task}, timeout=self._settings.grace)

    async def _stop_when_cancelled(self) -> None:
        try:
            await anyio.sleep_forever()
        finally:
            self.stop("its task was cancelled")  # of no effect when the run is over

    async def _end_backends(self) -> None:
        """Make the robots safe; what is lost cannot be asked to."""
        for backend in reversed(self._settings.backends):
            with anyio.move_on_after(self._settings.grace), suppress(BackendError):
                await backend.end_run()

    async def _perform_entry(self, root: Flow) -> Outcome:
        services, entry = self._services, self._entry
        invoked = services.entry = Invoked(entry, self._entry_again, len(root.scopes))
        place = Place(services, root, entry, None, (), entry.declaration.name, invoked)
        invocation = InvokeScenario(None, self._plan.entry, None, (), (), None, (), entry.declaration.span)
        modified = within(self._modifying, lasting(place, carry_scenario))

        def carry(inside: Place) -> Awaitable[Outcome]:
            record_instance(entry, _ENTRY, services)
            return modified(inside)

        return await recorded(invocation, place, carry)

    # -------------------------------------------------------- results

    def _record_start(self) -> None:
        self._trace.record(
            "run.start",
            scenario=self._plan.entry,
            file=self._plan.file,
            seed=self._settings.seed,
            parameters=self.parameters,
            overrides=dict(self._settings.overrides),
            clock=self._settings.clock.name,
            version=self._settings.version,
            **self._robots(),
        )

    def _robots(self) -> dict[str, Any]:
        """Which robots the actors are for whom that was chosen from outside."""
        homes = {name: each.home for name, each in self._settings.placements.items()}
        robots = {name: f"{home.name} of {home.backend.name}" for name, home in sorted(homes.items())}
        return {"robots": robots} if robots else {}

    def _conclude(self, wall_duration: float) -> Verdict:
        services = self._services
        decision = services.decision or self._decision()
        return Verdict(
            status=decision.status,
            reason=decision.reason,
            span=decision.span,
            duration=self._agenda.now,
            wall_duration=wall_duration,
            seed=self._settings.seed,
            scenario=self._plan.entry,
            file=self._plan.file,
            cancelled=tuple(services.cancelled),
            coverage=self._coverage.results(),
            logs=self._trace.last_logs,
            unobserved=tuple(services.contacts.unobserved),
            explanation=decision.explanation,
        )

    def _decision(self) -> Decision:
        """What the outcome of the entry scenario decides, where nothing else has."""
        root = self._services.root
        assert root is not None and root.outcome is not None
        outcome = root.outcome
        status = RunStatus.FAILED if outcome.failed else RunStatus.PASSED
        return Decision(status, outcome.reason, outcome.span, outcome.explanation)

    def _record_end(self, verdict: Verdict) -> None:
        self._trace.record(
            "run.end",
            status=verdict.status.value,
            reason=verdict.reason,
            source=str(verdict.span) if verdict.span else "",
            explanation=verdict.explanation.plain() if verdict.explanation else None,
            duration=verdict.duration,
            **({"unobserved": list(verdict.unobserved)} if verdict.unobserved else {}),
            # In whole tenths of seconds, so that traces do not differ by what the machine had else to do.
            cancelled=[each.plain() | {"clean_up": int(each.clean_up * 10) / 10} for each in verdict.cancelled],
        )


def _check_implementations(plan: Plan, settings: Settings) -> None:
    """Check that something carries out every action that can be invoked, and every modifier that is applied."""
    actions, modifiers = settings.actions, settings.modifiers
    for name, action in plan.actions.items():
        if name not in actions:
            invoked = (each.span for each in invocations(plan) if each.action == name)
            raise InvalidUse(
                f"nothing carries out the action `{name}`",
                next(invoked, action.span),
                f"the library `{action.library}` declares it without an implementation" if action.library else
                "actions are carried out by Python functions of a library",
            )  # fmt: skip
    for name, modifier in plan.modifiers.items():
        if modifier.library is not None and name not in modifiers:
            raise InvalidUse(
                f"nothing carries out the modifier `{name}`",
                modifier.span,
                f"the library `{modifier.library}` declares it without an implementation",
            )
