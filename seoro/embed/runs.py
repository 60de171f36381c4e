"""A run that programs have started."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import anyio
import anyio.lowlevel

from seoro.background import background
from seoro.embed.arguments import to_text
from seoro.embed.walltime import OF_PROGRAMS, WallLimit
from seoro.errors import BackendError, InvalidUse
from seoro.runtime.outputs import OutputFile
from seoro.runtime.reading import Readers, TraceReader
from seoro.runtime.run import Execution
from seoro.runtime.verdict import Verdict

if TYPE_CHECKING:
    from seoro.bridges.sim.node import SimulatorNode
    from seoro.bridges.wire import Artifact
    from seoro.embed.opening import Opened
    from seoro.film import Film, Recording


class Run:
    """A run that has been started with `start`."""

    def __init__(self, execution: Execution, seed: int, opened: Opened, readers: Readers) -> None:
        self._execution = execution
        self._simulator = opened.simulator
        self._aftermath = opened.aftermath
        self._readers = readers
        self._done = anyio.Event()
        self.seed = seed
        self.notes: tuple[str, ...] = ()  # of directives in the file that options replace

    @property
    def substitutions(self) -> dict[str, str]:
        """Names of robots by the actors that are carried out by a robot of another name, unless a lab says so."""
        return self._execution.substitutions

    def __repr__(self) -> str:
        how = "runs" if self.verdict is None else self.verdict.status.value
        return f"<Run of {self._execution.scenario}: {how}>"

    @property
    def parameters(self) -> dict[str, object]:
        """The chosen value of every parameter of the scenario."""
        return self._execution.parameters

    @property
    def parameter_texts(self) -> dict[str, str]:
        """The value of every parameter now, as the language writes it: `2.5mps`."""
        return self._execution.parameter_texts

    @property
    def verdict(self) -> Verdict | None:
        """The verdict; None while the run goes on."""
        return self._execution.verdict if self._done.is_set() else None

    @property
    def now(self) -> float:
        """The time since the start of the run, on its clock [s]."""
        return self._execution.now

    @property
    def fault(self) -> Exception | None:
        """The exception of an action's own code that ended the run, if one did."""
        return self._execution.fault

    @property
    def files(self) -> tuple[OutputFile, ...]:
        """The files that actions have left in the output folder, such as pictures of cameras."""
        return self._execution.files

    @property
    def simulator(self) -> SimulatorNode | None:
        """The simulator of the run, if it has one."""
        return self._simulator

    def trace(self) -> TraceReader:
        """The records of the trace, from the first to `run.end`, as they come.

        Any number of readers may read at once. A run that is started without `keep_trace` keeps the last 1000
        records only, and waits for slow readers if its clock is virtual or a simulator's: begin to read early.

        Raises:
            InvalidUse: The first records are not kept any more.
        """
        return self._readers.open()

    async def result(self) -> Verdict:
        """The verdict, once there is one. Does not raise when the scenario fails."""
        await self._done.wait()
        assert self._execution.verdict is not None, "every way to end a run gives one"
        return self._execution.verdict

    def stop(self, reason: str = "stopped by the program") -> None:
        """Cancel the run; what it started is cleaned up first. When it is over, what is done after it ends."""
        if self._done.is_set() and self._aftermath is not None:
            self._aftermath.cut_short()
        self._stop(to_text("reason", reason))

    def halt(self, reason: str) -> None:
        """Cancel the run, and leave out what a lab has done with its robots after it."""
        if self._aftermath is not None:
            self._aftermath.cut_short()
        self._stop(reason)

    def _stop(self, reason: str) -> None:
        self._readers.wait_no_more()
        self._execution.stop(reason)

    def give_up(self, reason: str) -> None:
        """End the run as an error, without a verdict on the system under test."""
        self._readers.wait_no_more()
        self._execution.fail_backend(BackendError(reason))

    async def artifacts(self) -> tuple[Artifact, ...]:
        """What the simulator has to show of the run, such as a picture; empty when it is gone or hangs."""
        if self._simulator is None or self._execution.has_clock_failed:
            return ()
        try:
            return await self._simulator.artifacts()
        except BackendError:
            return ()

    def recording(self, film: Film, file: Path) -> AbstractAsyncContextManager[Recording]:
        """Record a film of the simulator while a block lasts, in which the run runs; see `seoro.film`."""
        from seoro.film import recording  # noqa: PLC0415 - with the messages of simulators, as `_open`

        if self._simulator is None:
            raise InvalidUse("a film is of a simulator, and there is none", help="add `--sim mujoco`")
        return recording(self._simulator, film, file)

    @asynccontextmanager
    async def running(self, limit: WallLimit = OF_PROGRAMS) -> AsyncIterator[None]:
        """Run while the block lasts: when it ends, the run is stopped, if it is not over, and has cleaned up.

        Args:
            limit: Wall time after which the run ends as an error.
        """
        async with background() as group:
            group.start_soon(self._carry)
            group.start_soon(self._hold_to, limit)
            try:
                yield
            finally:
                self._stop("the block that started it has ended")  # of no effect when the run is over

    async def _hold_to(self, limit: WallLimit) -> None:
        with anyio.move_on_after(limit.seconds):
            await self._done.wait()
            return
        self.give_up(limit.reason)

    async def _carry(self) -> None:
        try:
            # Also in a loop that starts tasks eagerly, the block begins before the run, and can read it all.
            await anyio.lowlevel.cancel_shielded_checkpoint()
            if self._aftermath is not None:
                self._aftermath.follows = True
            await self._execution.run()
        finally:
            self._done.set()
            self._readers.end()
