"""Context of an action: its access to the run."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Collection, Sequence
from contextlib import AbstractAsyncContextManager, AbstractContextManager
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Any, NoReturn, TypeAlias, TypeVar, cast

from seoro.errors import ActionFailed, BackendLost
from seoro.runtime.actions.pending import Notifier, Pending
from seoro.runtime.contracts.backends import GoalStatus, Report
from seoro.runtime.execution.outputs import Outputs
from seoro.runtime.execution.services import Writer
from seoro.runtime.kernel.task import Waiter
from seoro.runtime.values.text import message_text
from seoro.runtime.verdict import Cancelled, RunStatus

if TYPE_CHECKING:  # libraries of actions name the context in annotations; checking them loads no runtime
    from seoro.lang.plan import InvokeAction, ValueType
    from seoro.runtime.execution.background import BackgroundResource
    from seoro.runtime.execution.blocking import Meter
    from seoro.runtime.execution.context import ExecutionContext
    from seoro.runtime.values.values import Actor, Value, Variable

T = TypeVar("T")
C = TypeVar("C")
Listen: TypeAlias = Callable[[Callable[[], None]], None]


class ActionContext:
    """The run as seen by one invocation of an action.

    Time is the run's clock: use `sleep` and `now` instead of those of asyncio or `time`. Only the action's own
    task may wait here (`sleep`, `ask`, `report`), not tasks that it starts.
    """

    def __init__(self, context: ExecutionContext, invocation: InvokeAction, meter: Meter) -> None:
        self._context = context
        self._invocation = invocation
        self._meter = meter
        self.thread: Thread | None = None  # of a blocking action
        self.grace = context.services.grace  # [s] for the clean-up of the action

    @property
    def name(self) -> str:
        """Name of the action."""
        return self._invocation.action

    @property
    def label(self) -> str | None:
        """Label of the invocation, or None."""
        return self._invocation.label

    @property
    def source(self) -> str:
        """Location of the invocation in the scenario: `file:line:column`."""
        return str(self._invocation.span)

    def labels_of(self, actions: Collection[str]) -> frozenset[str]:
        """Return the labels of all invocations of the given actions in the scenario."""
        found = (each.label for each in self._context.services.plan.action_invocations() if each.action in actions)
        return frozenset(label for label in found if label is not None)

    @property
    def now(self) -> float:
        """Time since the start of the run [s]."""
        return self._context.scheduler.now

    def log(self, message: str, level: str = "info") -> None:
        """Write a message into the trace; levels are `debug`, `info`, `warning` and `error`."""
        self._meter.hand_over()  # observers of the trace may be slow
        self._context.services.trace.log(message, level, self._invocation.span)
        self._meter.take_back()

    def record_margin(self, distance: float, limit: float) -> None:
        """Record how far a checked value was from its limit; the least margin of a run is in its verdict.

        Args:
            distance: Distance of the value to the limit, negative beyond it.
            limit: The limit, in the same unit.
        """
        self._context.services.margins.record(self.name, distance, limit, self._invocation.span)

    def type_of(self, parameter: str) -> ValueType | None:
        """Return the static type of the argument for a parameter; None if unknown."""
        for name, type_ in self._invocation.types:
            if name == parameter:
                return type_
        if any(name == parameter for name, _ in self._invocation.arguments):
            return None
        return self._context.services.plan.actions[self._invocation.action].structure.fields[parameter].type

    def text_of(self, parameter: str, value: Value) -> str:
        """Return the value of a parameter as written in the language; strings are returned as they are."""
        return message_text(value, self.type_of(parameter), self._context.services.plan.structures)

    def relay(self, messages: Sequence[str], level: str = "info") -> None:
        """Write messages into the trace between steps of the action, or after its end."""
        common = self._context.services.common
        common.relay(self._context.position, [(level, message, self._invocation.span) for message in messages])

    @property
    def file(self) -> Path:
        """The scenario file; relative paths in the scenario are relative to its folder."""
        return self._context.services.run.file

    def resolve_path(self, name: str) -> Path:
        """Resolve a path in the scenario: relative to the scenario file, or absolute."""
        return self._context.services.run.resolve_path(name)

    @property
    def output_folder(self) -> Path | None:
        """Output folder of the run, or None."""
        return self._context.services.run.output_directory

    def write_output(self, name: str, data: bytes, description: str) -> Path | None:
        """Write a file into the output folder of the run, and list it with the results.

        Args:
            name: File name without a folder. Duplicate names of a run get a number.
            data: Content.
            description: Description in a few words.

        Returns:
            The path of the file; None if the run has no output folder.

        Raises:
            ActionFailed: The name is invalid, or the file cannot be written.
        """
        folder = self.output_folder
        return self.shared(Outputs).write(folder, name, data, description) if folder is not None else None

    def reserve_output(self, name: str, description: str) -> Path:
        """Reserve a path in the output folder for a file or folder that the action writes itself.

        Args:
            name: As for `write_output`.
            description: Description in a few words.

        Raises:
            ActionFailed: The name is invalid, or the run has no output folder.
        """
        folder = self.output_folder
        if folder is None:
            raise ActionFailed(f"no output folder for {description}; choose one with `-o`")
        return self.shared(Outputs).reserve(folder, name, description)

    def update(self, variable: Variable[T], change: Callable[[T], T]) -> None:
        """Change a variable, between this delta cycle and the next (section 1 of the semantics).

        Args:
            variable: The variable.
            change: Returns the new value for the present one, which other changes may have updated.
        """
        context = self._context
        writer = Writer(context.position, context.number, context.task.past.cause)
        context.services.write(
            variable.holder, variable.name, variable.path, writer, lambda: cast("Value", change(variable.value))
        )

    async def sleep(self, duration: float) -> None:
        """Wait for a duration [s] of the run's clock."""
        self._check_task()
        waiter = Waiter(self._context.task)
        self._context.scheduler.wake_at(self.now + duration, waiter)
        await self._wait(waiter)

    async def wait_for(self, notifier: Notifier) -> None:
        """Wait until another action notifies."""
        self._check_task()
        waiter = Waiter(self._context.task)
        notifier.waiting.append((self._context.scheduler, waiter))
        waits = self._context.services.waits
        waits[waiter.task] = self._invocation.span
        try:
            await self._wait(waiter)
        finally:
            del waits[waiter.task]

    def shared(self, make: type[T]) -> T:
        """Return the instance of a class that all actions of the run share; created without arguments."""
        return self._context.services.common.shared(make)

    async def keep(self, manager: AbstractAsyncContextManager[T], grace: float = 0.0) -> BackgroundResource[T]:
        """Enter a context manager that stays open after the action, until the run ends.

        Args:
            manager: The context manager; entered and exited in one task, which is not that of the action.
            grace: Additional time for its exit, beyond the grace period [s].
        """
        services, context = self._context.services, self._context

        def closed(duration: float, overran: bool) -> None:
            services.cancelled.append(Cancelled(context.path, "action", self._invocation.span, duration, overran))
            if overran:
                reason = f"closing a resource of `{self.name}` took longer than {services.grace + grace:g} s"
                services.decide(RunStatus.ERROR, reason, self._invocation.span)

        return await services.common.lasting.keep(manager, grace, closed)

    def extend_grace(self, duration: float) -> None:
        """Extend the time for the clean-up of the action beyond the grace period, by a duration [s]."""
        self.grace = self._context.services.grace + duration

    async def ask(self, request: Awaitable[T]) -> T:
        """Await a request to a backend. It takes no time of the run's clock."""
        self._check_task()
        task = self._context.task
        task.awaits_answer = True
        try:
            return await request
        finally:
            task.awaits_answer = False

    async def report(self, pending: Pending) -> Report:
        """Wait for a report of a backend.

        Raises:
            BackendLost: The backend itself ended the goal, which ends the run as an error.
        """
        self._check_task()
        if pending.reported is None:
            waiter = Waiter(self._context.task)
            pending.waiter = (self._context, waiter)
            self._context.scheduler.expect(1)
            try:
                await self._wait(waiter)
            finally:
                self._context.scheduler.expect(-1)
        report = pending.reported
        assert report is not None
        if report.interrupted:  # raised here, so that no action mistakes it for a failure of the robot
            raise BackendLost(report.message or "the backend ended the goal by itself")
        return report

    async def follow(self, listen: Listen, act: Callable[[], None]) -> NoReturn:
        """Call `act` each time the outside world has new data, until the action is cancelled.

        The call happens in the instant of the arrival, without a step of the action.

        Args:
            listen: Registers a callback, which is called once, in the event loop, when data is available.
            act: Consumes the available data. Its exceptions are raised here.
        """
        task, failure = self._context.task, Pending()
        failed: list[Exception] = []

        def arrived() -> None:
            self._context.scheduler.act_now(take)

        def take() -> None:
            if task.is_cancelled or failure.settled or not follows:
                return
            self._meter.begin()
            try:
                act()
            except Exception as error:
                failed.append(error)
                failure.settle(Report(GoalStatus.ABORTED))
            else:
                listen(arrived)
            finally:
                self._meter.end()

        follows = True
        listen(arrived)
        try:
            await self.report(failure)
        finally:
            follows = False
        raise failed[0]

    async def _wait(self, waiter: Waiter) -> None:
        self._meter.end()  # when the last task parks, the scheduler continues within this call
        try:
            await self._context.scheduler.wait(waiter)
        finally:
            self._meter.begin()

    def _check_task(self) -> None:
        """Check that the action's own task waits: the scheduler would confuse another task with it."""
        if asyncio.current_task() is not self._context.task.handle:
            raise RuntimeError("only the action's own task may wait on its context, not tasks that it starts")

    def home(self, actor: Actor, contract: type[C]) -> tuple[C, str]:
        """Return the backend of an actor, and the actor's name there.

        Raises:
            ActionFailed: The actor has no backend, or its backend does not support the contract. This was checked
                before the run for actions that declare it at `@action`, and actors of the entry scenario.
        """
        home = self._context.services.homes.of(actor)
        if home is None:
            raise ActionFailed(f"no robot stands for `{actor.name}`")
        if not isinstance(home.backend, contract):
            raise ActionFailed(f"{home.backend.name}, the backend of `{actor.name}`, does not support this action")
        return home.backend, home.name

    def guard(
        self, actor: Actor, entities: Collection[str] | None, found: Callable[[str], None]
    ) -> AbstractContextManager[None]:
        """Watch the contacts of an actor's robot, which the action moves during the block.

        Args:
            actor: The actor.
            entities: Entities that it may touch, in addition to modifiers; None for all.
            found: Called with a reason when the robot moves into another entity; possibly several times.
        """
        services = self._context.services
        home = services.homes.of(actor)
        assert home is not None, "the action has requested it"
        names = None if entities is None else frozenset(entities)
        return services.contacts.guard(self._context.position, home, names, found)

    def anywhere(self, contract: type[C]) -> C:
        """Return a backend that supports a contract, for actions that declare it at `@action`."""
        backend = self.find(contract)
        assert backend is not None, "checked when the run was instantiated"
        return backend

    def by_name(self, name: str, contract: type[C]) -> C:
        """As `anywhere`, but prefer the backend of an actor with this name there."""
        backend = self._context.services.homes.by_name(name, contract)
        assert backend is not None, "checked when the run was instantiated"
        return backend

    def find(self, contract: type[C]) -> C | None:
        """Return a backend that supports a contract, or None."""
        return self._context.services.homes.anywhere(contract)

    def is_home(self, actor: Actor, contract: type[Any]) -> bool:
        """Whether the backend of an actor supports a contract."""
        home = self._context.services.homes.of(actor)
        return home is not None and isinstance(home.backend, contract)
