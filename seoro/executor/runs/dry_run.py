"""Dry runs: check a scenario with the packages and permissions of the executor, and choose its values.

A process like that of a run does this, and ends before the run would begin. It needs no run slot; there is one dry
run at a time.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import anyio

from seoro.bridges.executor import messages as wire
from seoro.bridges.wire import Result, encode
from seoro.bridges.wire.refusal import RequestRefused
from seoro.concurrency.background import background
from seoro.concurrency.forks.using import NoProcess
from seoro.executor.job import Job, make_job
from seoro.executor.limits import Limits
from seoro.executor.process.frames import Frame
from seoro.executor.process.pool import Pool, Worker
from seoro.executor.runs.usage import exceeds
from seoro.executor.storage.run_folder import RunFolder

LONGEST: Final = wire.LONGEST_DRY_RUN - 5.0  # [s]; the client waits a little longer


class DryRuns:
    """Dry runs of an executor.

    Args:
        pool: Pool of processes.
        can_sandbox: Whether the executor can sandbox runs.
    """

    def __init__(self, pool: Pool, *, can_sandbox: bool = False) -> None:
        self._pool = pool
        self._can_sandbox = can_sandbox
        self._is_busy = False

    @contextmanager
    def one(self) -> Iterator[None]:
        """Reserve the executor for a dry run while the block lasts.

        Raises:
            RequestRefused: Another dry run is active.
        """
        if self._is_busy:
            raise RequestRefused(wire.UNAVAILABLE, "the executor is busy with another dry run")
        self._is_busy = True
        try:
            yield
        finally:
            self._is_busy = False

    async def execute(self, manifest: wire.Manifest, folder: RunFolder, limits: Limits) -> wire.DryRunResult:
        """Dry-run an unpacked bundle.

        Args:
            manifest: Manifest of the bundle.
            folder: Folder of the bundle.
            limits: Limits of the client.

        Raises:
            RequestRefused: The dry run failed without a result.
        """
        try:
            job = make_job(_without_waiting(manifest), folder, limits, can_sandbox=self._can_sandbox, is_dry=True)
            return await self._execute_job(job, limits)
        except (NoProcess, OSError) as error:
            raise _failed(str(error)) from error

    async def _execute_job(self, job: Job, limits: Limits) -> wire.DryRunResult:
        worker = await self._pool.acquire()
        try:
            worker.send(Frame.JOB, encode(job))
            return await _result(worker, limits)
        except BaseException:
            worker.kill()
            raise
        finally:
            worker.close()
            with anyio.CancelScope(shield=True):
                await worker.wait()


def _without_waiting(manifest: wire.Manifest) -> wire.Manifest:
    """Return the manifest without waiting for busy robots."""
    options = manifest.options
    at_once = options.model_copy(update={"leasing": options.leasing.model_copy(update={"wait": None})})
    return manifest.model_copy(update={"options": at_once})


async def _result(worker: Worker, limits: Limits) -> wire.DryRunResult:
    """Receive the result of a dry run from its process."""
    killed = ""

    async def hold_to_usage() -> None:
        nonlocal killed
        killed = (await exceeds(worker.process, limits)).reason
        worker.kill()

    tried = wire.DryRunResult()
    with anyio.move_on_after(LONGEST):
        async with background() as duties:
            duties.start_soon(hold_to_usage)
            async for kind, data in worker.frames():
                if kind is Frame.DRY_RUN_RESULT:
                    tried = wire.DRY_RUN.read_reply(data)
                elif kind is Frame.END:
                    return wire.DryRunResult(end=data) if data else tried
            raise _failed(killed or "its process died")
    raise _failed(f"not finished within {LONGEST:g} s")


def _failed(reason: str) -> RequestRefused:
    return RequestRefused(Result.OPERATION_FAILED, f"the dry run failed: {reason}")
