"""What an action sees of the run."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Collection, Sequence
from contextlib import AbstractAsyncContextManager, AbstractContextManager
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Any, NoReturn, TypeAlias, TypeVar, cast

from seoro.errors import ActionFailed, BackendLost
from seoro.runtime.agenda import Agenda, Waiter
from seoro.runtime.contracts import GoalStatus, Report
from seoro.runtime.invocations import invocations
from seoro.runtime.outputs import Outputs
from seoro.runtime.value_text import message_text
from seoro.runtime.verdict import Cancelled, RunStatus

if TYPE_CHECKING:  # libraries of actions name the context in annotations: to check one is not to load what runs it
    from seoro.lang.plan import InvokeAction, ValueType
    from seoro.runtime.blocking import Meter
    from seoro.runtime.lasting import Kept
    from seoro.runtime.place import Place
    from seoro.runtime.values import Actor, Value, Variable

T = TypeVar("T")
C = TypeVar("C")
Listen: TypeAlias = Callable[[Callable[[], None]], None]


class Pending:
    """A report that a backend will give later."""

    def __init__(self) -> None:
        self._report: Report | None = None
        self._waiter: tuple[Place, Waiter] | None = None

    @property
    def settled(self) -> bool:
        """Whether the report is there."""
        return self._report is not None

    def settle(self, report: Report) -> None:
        """Give the report; for backends."""
        self._report = report
        if self._waiter is not None:
            place, waiter = self._waiter
            place.agenda.arrive(waiter)


class Occasion:
    """Something that actions bring about, again and again, and that others wait for."""

    def __init__(self) -> None:
        self._waiting: list[tuple[Agenda, Waiter]] = []

    def happen(self) -> None:
        """It happens: those who wait for it go on, in the next round."""
        waiting, self._waiting = self._waiting, []
        for agenda, waiter in waiting:
            agenda.fire(waiter)


class ActionContext:
    """The run, as one invocation of an action sees it.

    Time is the run's clock: use `sleep` and `now`, not those of asyncio or `time`. What waits here (`sleep`,
    `ask`, `report`) is for the action's own task, not for tasks that it starts.
    """

    def __init__(self, place: Place, invocation: InvokeAction, meter: Meter) -> None:
        self._place = place
        self._invocation = invocation
        self._meter = meter
        self.thread: Thread | None = None  # in which it blocks, if it does
        self.grace = place.services.grace  # [s] for its clean-up

    @property
    def name(self) -> str:
        """The name of the action."""
        return self._invocation.action

    @property
    def label(self) -> str | None:
        """The label of the invocation, if it has one."""
        return self._invocation.label

    @property
    def source(self) -> str:
        """Where the invocation stands in the scenario: `file:line:column`."""
        return str(self._invocation.span)

    def labels_of(self, actions: Collection[str]) -> frozenset[str]:
        """The labels under which the scenario invokes any of some actions, by their names."""
        found = (each.label for each in invocations(self._place.services.plan) if each.action in actions)
        return frozenset(label for label in found if label is not None)

    @property
    def now(self) -> float:
        """Time since the start of the run [s]."""
        return self._place.agenda.now

    def log(self, message: str, level: str = "info") -> None:
        """Write a message into the trace; levels are `debug`, `info`, `warning` and `error`."""
        self._meter.hand_over()  # who reads the trace may be slow
        self._place.services.trace.log(message, level, self._invocation.span)
        self._meter.take_back()

    def type_of(self, parameter: str) -> ValueType | None:
        """The static type of the argument for a parameter, which may be of any type; None if it is unknown."""
        for name, type_ in self._invocation.types:
            if name == parameter:
                return type_
        if any(name == parameter for name, _ in self._invocation.arguments):
            return None
        return self._place.services.plan.actions[self._invocation.action].structure.fields[parameter].type

    def text_of(self, parameter: str, value: Value) -> str:
        """The value of a parameter as the language writes it; that of a string is the string itself."""
        return message_text(value, self.type_of(parameter), self._place.services.plan.structures)

    def relay(self, messages: Sequence[str], level: str = "info") -> None:
        """Write messages into the trace that come while the action waits, or after it has ended."""
        common = self._place.services.common
        common.relay(self._place.position, [(level, message, self._invocation.span) for message in messages])

    @property
    def file(self) -> Path:
        """The scenario file; what a scenario names by a relative path lies beside it."""
        return self._place.services.run.file

    def place_of(self, name: str) -> Path:
        """Where a file or a folder is that the scenario names, relative to its own file or by an absolute path."""
        return self._place.services.run.place_of(name)

    def leave_file(self, name: str, data: bytes, description: str) -> Path | None:
        """Write a file into the output folder of the run, where it is listed with the results.

        Args:
            name: Of the file, without a folder. If the run has left one of that name, the new one gets a number.
            data: What is in it.
            description: What it is, in a few words.

        Returns:
            The file; None if the run has no output folder, and nothing is written.

        Raises:
            ActionFailed: The name is none for a file, or it cannot be written.
        """
        folder = self._place.services.run.output_directory
        return self.shared(Outputs).write(folder, name, data, description) if folder is not None else None

    def reserve_output(self, name: str, description: str) -> Path:
        """A place for a file or folder that the action writes itself, in the output folder of the run.

        Args:
            name: As `leave_file` has it, with a number if the run has left one of that name.
            description: What it is, in a few words.

        Raises:
            ActionFailed: The name is none for a file, or the run has no output folder.
        """
        folder = self._place.services.run.output_directory
        if folder is None:
            raise ActionFailed(f"there is no place for {description}: give the run an output folder with `-o`")
        return self.shared(Outputs).reserve(folder, name, description)

    def update(self, variable: Variable[T], change: Callable[[T], T]) -> None:
        """Change a variable, between this round and the next (section 1 of the semantics).

        Args:
            variable: The variable.
            change: Gives the new value for the one that it holds then, which others may have changed meanwhile.
        """
        self._place.services.write(
            variable.holder,
            variable.name,
            variable.path,
            self._place,
            lambda: cast("Value", change(variable.value)),
        )

    async def sleep(self, duration: float) -> None:
        """Wait for a duration [s] of the run's clock."""
        self._check_task()
        waiter = Waiter(self._place.flow)
        self._place.agenda.at(self.now + duration, waiter)
        await self._wait(waiter)

    async def wait_for(self, occasion: Occasion) -> None:
        """Wait until something happens that another action brings about."""
        self._check_task()
        waiter = Waiter(self._place.flow)
        occasion._waiting.append((self._place.agenda, waiter))
        waits = self._place.services.waits
        waits[waiter.flow] = self._invocation.span
        try:
            await self._wait(waiter)
        finally:
            del waits[waiter.flow]

    def shared(self, make: type[T]) -> T:
        """The one object of a class that all actions of the run have in common, made without arguments."""
        return self._place.services.common.shared(make)

    async def keep(self, manager: AbstractAsyncContextManager[T], grace: float = 0.0) -> Kept[T]:
        """Open something that stays open when the action ends, until the run does.

        Args:
            manager: Opens and closes it, both in one task, which is not that of the action.
            grace: How much longer than the grace period closing it may take [s].
        """
        services, place = self._place.services, self._place

        def told(duration: float, overran: bool) -> None:
            services.cancelled.append(Cancelled(place.path, "action", self._invocation.span, duration, overran))
            if overran:
                reason = f"what `{self.name}` left open took longer than {services.grace + grace:g} s to close"
                services.decide(RunStatus.ERROR, reason, self._invocation.span)

        return await services.common.lasting.keep(manager, grace, told)

    def extend_grace(self, duration: float) -> None:
        """Say that the clean-up of the action may take longer than the grace period, by a duration [s]."""
        self.grace = self._place.services.grace + duration

    async def ask(self, request: Awaitable[T]) -> T:
        """Await a request to a backend, which takes no time of the run's clock."""
        self._check_task()
        flow = self._place.flow
        flow.asking = True
        try:
            return await request
        finally:
            flow.asking = False

    async def report(self, pending: Pending) -> Report:
        """Wait for a report of a backend.

        Raises:
            BackendLost: The backend ended the goal for a reason of its own, which ends the run as an error.
        """
        self._check_task()
        if pending._report is None:
            waiter = Waiter(self._place.flow)
            pending._waiter = (self._place, waiter)
            self._place.agenda.expect(1)
            try:
                await self._wait(waiter)
            finally:
                self._place.agenda.expect(-1)
        report = pending._report
        assert report is not None
        if report.interrupted:  # here, so that no action can take it for a failure of the robot
            raise BackendLost(report.message or "the backend ended the goal for a reason of its own")
        return report

    async def follow(self, listen: Listen, act: Callable[[], None]) -> NoReturn:
        """Do something each time that the outside world has something, until the action is ended.

        It is done in the instant in which that arrives, without a step of the action.

        Args:
            listen: Has something called once, in the event loop, when there is something.
            act: Takes what there is. What it raises is raised here.
        """
        flow, failure = self._place.flow, Pending()
        failed: list[Exception] = []

        def arrived() -> None:
            self._place.agenda.happen(take)

        def take() -> None:
            if flow.ended is not None or failure.settled or not follows:
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
        self._meter.end()  # when the last flow parks, the agenda goes on within its call, maybe with this one
        try:
            await self._place.agenda.wait(waiter)
        finally:
            self._meter.begin()

    def _check_task(self) -> None:
        """The agenda knows one task for a flow; another that waits would be taken for it."""
        if asyncio.current_task() is not self._place.flow.task:
            raise RuntimeError("an action waits on its context in its own task only, not in tasks that it starts")

    def home(self, actor: Actor, contract: type[C]) -> tuple[C, str]:
        """The backend in which an actor lives, and what the actor is called there.

        Raises:
            ActionFailed: It lives nowhere, or its home does not serve the contract. For actions that said at
                `@action` what they need, and actors of the entry scenario, this was checked before the run.
        """
        home = self._place.services.homes.of(actor)
        if home is None:
            raise ActionFailed(f"`{actor.name}` lives nowhere")
        if not isinstance(home.backend, contract):
            raise ActionFailed(f"{home.backend.name}, where `{actor.name}` lives, cannot do this")
        return home.backend, home.name

    def guard(
        self, actor: Actor, entities: Collection[str] | None, found: Callable[[str], None]
    ) -> AbstractContextManager[None]:
        """Watch over the contacts of an actor's robot, which the action moves while the block lasts.

        Args:
            actor: The actor.
            entities: What it may touch, besides what modifiers allow; None for everything.
            found: Called with the reason when the robot moves into something else; more than once, maybe.
        """
        services = self._place.services
        home = services.homes.of(actor)
        assert home is not None, "the action has asked for it"
        names = None if entities is None else frozenset(entities)
        return services.contacts.guard(self._place.position, home, names, found)

    def anywhere(self, contract: type[C]) -> C:
        """A backend of the run that serves a contract; for actions that said so at `@action`."""
        backend = self.find(contract)
        assert backend is not None, "checked when the run was instantiated"
        return backend

    def by_name(self, name: str, contract: type[C]) -> C:
        """As `anywhere`, but preferably the backend in which an actor lives that has a name there."""
        backend = self._place.services.homes.by_name(name, contract)
        assert backend is not None, "checked when the run was instantiated"
        return backend

    def find(self, contract: type[C]) -> C | None:
        """A backend of the run that serves a contract, if there is one."""
        return self._place.services.homes.anywhere(contract)

    def is_home(self, actor: Actor, contract: type[Any]) -> bool:
        """Whether an actor lives in a backend that serves a contract."""
        home = self._place.services.homes.of(actor)
        return home is not None and isinstance(home.backend, contract)
