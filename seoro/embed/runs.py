"""Run of a scenario, for programs."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager, suppress
from math import isinf
from pathlib import Path
from typing import TYPE_CHECKING

from seoro.embed.arguments import to_text
from seoro.embed.subscriptions import CAPACITY, EventSubscription, OnFull, check_buffer, open_subscription
from seoro.embed.time_limit import PROGRAM_LIMIT, WallLimit
from seoro.errors import BackendError, UsageError
from seoro.runtime.events.occurrence import Occurrence
from seoro.runtime.execution.outputs import OutputFile
from seoro.runtime.run import Execution
from seoro.runtime.trace.reader import Readers, TraceReader
from seoro.runtime.verdict import Verdict

if TYPE_CHECKING:
    from seoro.bridges.sim.node import SimulatorNode
    from seoro.bridges.wire import Artifact
    from seoro.embed.backends import OpenBackends
    from seoro.embed.video import Recording, VideoOptions


class Run:
    """Run of a scenario, made by `start`."""

    def __init__(self, execution: Execution, seed: int, opened: OpenBackends, readers: Readers) -> None:
        self._execution = execution
        self._simulator = opened.simulator
        self._teardown = opened.teardown
        self._readers = readers
        self._done = asyncio.Event()
        self._has_begun = False
        self.seed = seed
        self.notes: tuple[str, ...] = ()  # about directives that options replace

    @property
    def substitutions(self) -> dict[str, str]:
        """Robots with other names than their actors, by actor, apart from assignments of a lab."""
        return self._execution.substitutions

    def __repr__(self) -> str:
        how = "runs" if self.verdict is None else self.verdict.status.value
        return f"<Run of {self._execution.scenario}: {how}>"

    def _repr_html_(self) -> str:
        """Return the run for notebooks."""
        from seoro.text.notebook import card  # noqa: PLC0415 - for notebooks only

        if self.verdict is not None:
            return self.verdict.card(self.parameter_texts)
        facts = {"time": f"{self.now:.3f} s", "seed": self.seed}
        return card(self._execution.scenario, "running", facts | self.parameter_texts)

    @property
    def parameters(self) -> dict[str, object]:
        """Chosen values of all parameters of the scenario."""
        return self._execution.parameters

    @property
    def parameter_texts(self) -> dict[str, str]:
        """Current values of all parameters in the notation of the language, such as `2.5mps`."""
        return self._execution.parameter_texts

    @property
    def verdict(self) -> Verdict | None:
        """The verdict; None while the run is active."""
        return self._execution.verdict if self._done.is_set() else None

    @property
    def now(self) -> float:
        """Time since the start of the run on its clock [s]."""
        return self._execution.now

    @property
    def fault(self) -> Exception | None:
        """Exception in an action's code that ended the run, if any."""
        return self._execution.fault

    @property
    def files(self) -> tuple[OutputFile, ...]:
        """Files of actions in the output folder, such as camera images."""
        return self._execution.files

    @property
    def simulator(self) -> SimulatorNode | None:
        """Simulator of the run, if any."""
        return self._simulator

    def trace(self) -> TraceReader:
        """Iterate over the records of the trace as they occur, from the first to `run.end`.

        Several readers may read at once. Without `keep_trace`, a run keeps only the last 1000 records, so start to
        read early. On a virtual or simulated clock, it waits for slow readers.

        Raises:
            UsageError: The first records were dropped already.
        """
        return self._readers.open()

    async def result(self) -> Verdict:
        """Wait for the verdict and return it. Does not raise if the scenario fails."""
        await self._done.wait()
        assert self._execution.verdict is not None, "an ended run has a verdict"
        return self._execution.verdict

    def stop(self, reason: str = "stopped by the program") -> None:
        """Cancel the run, with a clean-up. After the run, this cancels the teardown of its lab."""
        if self._done.is_set() and self._teardown is not None:
            self._teardown.abort()
        self._stop(to_text("reason", reason))

    def halt(self, reason: str) -> None:
        """Cancel the run without the teardown of its lab."""
        if self._teardown is not None:
            self._teardown.abort()
        self._stop(reason)

    def _stop(self, reason: str) -> None:
        self._readers.wait_no_more()
        self._execution.stop(reason)

    def abort(self, reason: str) -> None:
        """End the run with an error, without a verdict on the system under test."""
        self._readers.wait_no_more()
        self._execution.fail_backend(BackendError(reason))

    def subscribe(
        self, event: str, *, capacity: int = CAPACITY, on_full: OnFull = "fail"
    ) -> AbstractAsyncContextManager[EventSubscription]:
        """Subscribe to an event while a block lasts: `async with run.subscribe("robot.arrived") as events`.

        The subscription receives all later occurrences in order; its iteration ends with the run.

        Args:
            event: Name: `go` or `x.end` of the entry scenario, `robot.arrived` of an actor, or as in traces.
            capacity: Capacity of the buffer, in occurrences.
            on_full: Policy for a full buffer: `fail` raises `SubscriptionOverflow` at the first missing
                occurrence, `drop_oldest` counts dropped ones in `lost`, `wait` stops virtual or simulated time.

        Raises:
            UsageError: The event is unknown, or an argument is invalid or impossible.
        """
        application = self._execution.application
        real = "" if application.is_master_of_time else "the real clock cannot be stopped"
        check_buffer(capacity, on_full, real)
        name = application.event_name(to_text("event", event))
        return open_subscription(self._readers, name, capacity, on_full)

    async def emit(self, event: str, /, **fields: object) -> Occurrence:
        """Emit an event declared with `external`, and wait until it has occurred, at the next instant.

        Args:
            event: Name of the event: `operator_ready` of the entry scenario, `robot.released` of an actor.
            fields: Arguments of the event: numbers in SI base units, members of enumerations by name.

        Raises:
            UsageError: The event is unknown or not external, fields are invalid, or the run is not active.
        """
        if not self._has_begun:
            raise UsageError("the run has not started yet", help="emit within `running()`")
        return await self._execution.application.emit(to_text("event", event), fields)

    async def artifacts(self) -> tuple[Artifact, ...]:
        """Fetch the artifacts of the simulator, such as an image; empty if it is lost."""
        if self._simulator is None or self._execution.has_clock_failed:
            return ()
        try:
            return await self._simulator.artifacts()
        except BackendError:
            return ()

    def recording(self, view: VideoOptions, file: Path) -> AbstractAsyncContextManager[Recording]:
        """Record a video of the simulator while a block with `running` lasts; see `seoro.embed.video`."""
        from seoro.embed.video import recording  # noqa: PLC0415 - with the messages of simulators, as `_open`

        if self._simulator is None:
            raise UsageError("a video needs a simulator", help="add `--sim mujoco`")
        return recording(self._simulator, view, file)

    @asynccontextmanager
    async def running(self, limit: WallLimit = PROGRAM_LIMIT) -> AsyncIterator[None]:
        """Run while the block lasts. At its end, an active run is stopped, and has cleaned up.

        Args:
            limit: Wall time after which the run ends with an error.
        """
        self._has_begun = True
        raised: BaseException | None = None
        begun, loop = asyncio.Event(), asyncio.get_running_loop()
        async with asyncio.TaskGroup() as group:
            group.create_task(self._execute(begun))
            limiting = None if isinf(limit.seconds) else loop.call_later(limit.seconds, self._enforce, limit)
            try:
                await asyncio.sleep(0)  # a task that is cancelled before its first step never runs
                begun.set()
                yield
            except asyncio.CancelledError:
                raise
            except BaseException as error:  # of the block: raised without an exception group
                raised = error
            finally:
                if limiting is not None:
                    limiting.cancel()
                self._stop("the block that started it has ended")  # no effect on an ended run
        if raised is not None:
            raise raised

    def _enforce(self, limit: WallLimit) -> None:
        if not self._done.is_set():
            self.abort(limit.reason)

    async def _execute(self, begun: asyncio.Event) -> None:
        """Run once the block has started, so that it can read the whole trace, also in loops with eager tasks."""
        try:
            with suppress(asyncio.CancelledError):  # a run that is stopped already still writes a complete trace
                await begun.wait()
            if self._teardown is not None:
                self._teardown.is_due = True
            await self._execution.run()
        finally:
            self._done.set()
            self._readers.end()
