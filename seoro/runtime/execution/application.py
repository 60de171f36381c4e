"""Events of the embedding application: they occur in the next instant, recorded with their origin."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from functools import partial

from seoro.errors import UsageError
from seoro.lang.plan import Plan
from seoro.runtime.events.external import Emission, ExternalEvents, trace_name
from seoro.runtime.events.occurrence import Occurrence
from seoro.runtime.execution.services import Services
from seoro.runtime.execution.settings import Settings
from seoro.runtime.instances.instances import Instance
from seoro.runtime.kernel.timers import Timer
from seoro.runtime.values.environment import Environment
from seoro.runtime.values.values import plain


class Application:
    """Emits events for the embedding application.

    Args:
        plan: The plan.
        entry: Instance of the entry scenario.
        settings: Settings of the run, with the external events and recorded emissions.

    Raises:
        UsageError: An external event is undeclared, or recorded arguments do not match.
    """

    def __init__(self, plan: Plan, entry: Instance, settings: Settings) -> None:
        self._plan = plan
        self._settings = settings
        self._events = ExternalEvents(plan, entry, settings.external)
        self._entry = entry
        self._services: Services | None = None
        self._has_begun = asyncio.Event()
        self._is_over = False
        self._pending: set[asyncio.Future[Occurrence]] = set()
        recorded = settings.recorded or ()
        self._recorded = [(each.time, self._check(each.name, each.arguments)) for each in recorded]

    @property
    def external(self) -> tuple[str, ...]:
        """Trace names of the events that may be emitted."""
        return self._events.names

    @property
    def is_master_of_time(self) -> bool:
        """Whether time passes only when the run advances it."""
        return self._settings.clock.deterministic

    def event_name(self, name: str) -> str:
        """Return the trace name of an event.

        Raises:
            UsageError: The run cannot have such an event.
        """
        return trace_name(name, self._plan, self._entry, bool(self._settings.backends))

    def begin(self, services: Services) -> None:
        """Start emissions. Called in the first instant, with the services of the run."""
        self._services = services
        self._has_begun.set()
        if self._settings.recorded is None:
            services.scheduler.expect(1)
        for time, emission in self._recorded:
            services.scheduler.act_at(time, Timer(partial(self._occur, emission, None)))

    def end(self) -> None:
        """Refuse pending emissions at the end of the run."""
        self._is_over = True
        self._has_begun.set()
        for pending in tuple(self._pending):
            if not pending.done():
                pending.set_exception(_over())

    async def emit(self, name: str, arguments: Mapping[str, object]) -> Occurrence:
        """Emit an event, and wait until it has occurred.

        Args:
            name: The name of the event.
            arguments: Its arguments as plain values.

        Raises:
            UsageError: The event is not external, the arguments do not match, or the run is over.
        """
        self._check(name, arguments)
        await self._has_begun.wait()
        if self._is_over or self._services is None:
            raise _over()
        emission = self._check(name, arguments)
        occurred: asyncio.Future[Occurrence] = asyncio.get_running_loop().create_future()
        timer = Timer(partial(self._occur, emission, occurred))
        self._pending.add(occurred)
        try:
            self._services.scheduler.act_next(timer)
            return await occurred
        finally:
            timer.over = True
            self._pending.discard(occurred)

    def _check(self, name: str, arguments: Mapping[str, object]) -> Emission:
        scope = Environment(self._entry, self._plan)
        if self._services is not None:
            scope = self._services.environment_of(self._present, scope)
        return self._events.emission(name, arguments, scope)

    @property
    def _present(self) -> Instance:
        """The current instance of the entry scenario; modifiers may run it repeatedly."""
        assert self._services is not None and self._services.entry is not None, "the run has begun"
        entry = self._services.entry.instance
        assert isinstance(entry, Instance), "the entry is a scenario"
        return entry

    def _occur(self, emission: Emission, occurred: asyncio.Future[Occurrence] | None) -> None:
        """Emit an event at the start of an instant, and resolve its future."""
        services, (external, arguments) = self._services, emission
        assert services is not None, "the run has begun"
        if occurred is not None and occurred.done():
            return
        event = services.events.declared(external.actor or self._present, external.declared.name)
        services.events.emit_outside(event, arguments)
        if occurred is not None:
            shown = {name: plain(value) for name, value in arguments.items()}
            occurred.set_result(Occurrence(services.scheduler.now, event.name, shown))


def _over() -> UsageError:
    return UsageError("the run is over; no more events can be emitted")
