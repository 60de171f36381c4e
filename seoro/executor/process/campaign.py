"""Runs of a campaign in the process of a worker: one after another, each reported by its row in the trace."""

from __future__ import annotations

import asyncio
import shutil
import time
from contextlib import AsyncExitStack, suppress
from pathlib import Path

from seoro.bridges.executor.messages import RUNS, CampaignWorker, PlannedRuns
from seoro.bridges.wire import decode
from seoro.bundle.unpack import limit_of
from seoro.campaign.pool.simulators import own_simulator, simulator_node
from seoro.campaign.remote.record import to_record
from seoro.campaign.runs import End, Planned
from seoro.campaign.store.folder import KEPT
from seoro.campaign.work.job import Job as Work
from seoro.campaign.work.running import SimulatorDied, Stopped, Worker
from seoro.embed.options import Options
from seoro.embed.scenarios import Scenario
from seoro.errors import BackendError
from seoro.executor.job import Job
from seoro.executor.permissions import vet_plan
from seoro.executor.process.control import AFTER_STOP, Control
from seoro.executor.process.frames import Frame
from seoro.executor.process.trace_pipe import TracePipe
from seoro.lab.selectors import split_selectors
from seoro.lang.frontend import lower


async def make_runs(
    job: Job, campaign: CampaignWorker, scenario: Scenario, options: Options, trace: TracePipe, requests: Control
) -> None:
    """Make the runs of a campaign, until the executor stops them.

    Args:
        job: The job.
        campaign: The campaign.
        scenario: Its scenario.
        options: Options that its runs share.
        trace: Pipe to the executor, for rows.
        requests: Requests of the executor.

    Raises:
        InvalidScenario, UsageError: An action is not allowed, or the simulator is unknown or not installed.
        BackendError: The simulator did not start.
    """
    work = Work(
        digest=campaign.digest,
        version=campaign.version,
        keep=campaign.keep,
        folder=Path(job.output),
        scenario=scenario,
        options=options,
        limit=limit_of(job.manifest.options),
        film=job.manifest.options.film,
        parquet=campaign.parquet,
    )
    _vet(scenario, options, job)
    loop, given, ending = asyncio.get_running_loop(), _GivenRuns(trace, work.folder / KEPT), _Ending()
    requests.on_runs(lambda data: loop.call_soon_threadsafe(given.take, data))
    requests.on_end(lambda kind, reason: loop.call_soon_threadsafe(ending.end, kind, reason))
    with suppress(Stopped):
        while True:
            async with AsyncExitStack() as stack:
                ending.worker = await _open_worker(work, campaign.name, stack)
                stack.callback(ending.worker.close)
                trace.send(Frame.BEGIN, f"worker {campaign.name} of a campaign")
                await _work(ending.worker, given, trace)


def _vet(scenario: Scenario, options: Options, job: Job) -> None:
    """Check the permissions of the plan once, since each run would be refused.

    Raises:
        InvalidScenario, UsageError: An action is not allowed, or an option is invalid.
    """
    overrides, _ = split_selectors(options.overrides)
    vet_plan(lower(scenario.checked, options.name, overrides), job.allowed)


async def _work(worker: Worker, given: _GivenRuns, trace: TracePipe) -> None:
    """Make runs until one ends as an error, maybe of the simulator.

    Raises:
        Stopped: The worker was stopped.
        BackendError: Its simulator has died; the coordinator gives the run to another worker.
    """
    began = time.monotonic()
    while True:
        planned = await given.next()
        try:
            row = await worker.make(planned)
        except SimulatorDied as died:
            raise BackendError("the simulator ended its process") from died
        trace.send(Frame.TRACE, to_record(row, time.monotonic() - began))
        if row.status is End.ERROR:
            return


async def _open_worker(work: Work, name: str, stack: AsyncExitStack) -> Worker:
    """Return a worker, with a simulator of its own if its runs need one."""
    simulator = own_simulator(work.options.simulator)
    if simulator is None:
        return Worker(work, name)
    node = await stack.enter_async_context(simulator_node(simulator))
    return Worker(work, name, node.endpoint, node.process.pid)


class _GivenRuns:
    """Runs that the coordinator has given, and that have not begun.

    Args:
        trace: Pipe to the executor.
        kept: Folder with the folders of kept runs.
    """

    def __init__(self, trace: TracePipe, kept: Path) -> None:
        self._trace = trace
        self._kept = kept
        self._runs: asyncio.Queue[Planned] = asyncio.Queue()
        self._part = 0  # last one

    def take(self, data: bytes) -> None:
        """Take the runs of an encoded `messages.PlannedRuns`, and remove the folders of fetched runs."""
        given = decode(PlannedRuns, data, RUNS)
        if given.part > self._part:
            self._part = given.part
            for number in given.fetched:
                shutil.rmtree(self._kept / f"{number:06}", ignore_errors=True)
            for run in given.runs:
                self._runs.put_nowait(Planned(**run.model_dump()))
        self._trace.send(Frame.RUNS_TAKEN, str(given.part))

    async def next(self) -> Planned:
        """Wait for the next run."""
        return await self._runs.get()


class _Ending:
    """Stops the worker of the present task when the executor wants that.

    Attributes:
        worker: The worker; None before it begins.
    """

    def __init__(self) -> None:
        self.worker: Worker | None = None
        self._task = asyncio.current_task()

    def end(self, kind: Frame, reason: str) -> None:
        """Stop the present run; without one, end the task. `HALT` stops it without further motion of robots."""
        if self.worker is not None and self.worker.has_run:
            if kind is Frame.HALT:
                self.worker.halt(reason)
            else:
                self.worker.stop(reason)
                asyncio.get_running_loop().call_later(AFTER_STOP, self.worker.halt, reason)
        elif self._task is not None:
            self._task.cancel()
