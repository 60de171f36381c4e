"""Dry runs: a scenario is checked with all that is installed here and allowed, and its values are chosen.

That is done by a process such as runs have, which ends where the run would begin. It waits for no turn; there is
one at a time.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import anyio

from seoro.background import background
from seoro.bridges.executor import messages as wire
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused
from seoro.executor.frames import Frame, Job
from seoro.executor.jobs import make_job
from seoro.executor.limits import Limits
from seoro.executor.quota import exceeds
from seoro.executor.store import RunFolder
from seoro.executor.workers import NoProcess, Pool, Worker

LONGEST: Final = wire.LONGEST_DRY_RUN - 5.0  # [s]; whoever asks waits a little longer


class DryRuns:
    """The dry runs of an executor.

    Args:
        pool: Of processes.
        can_sandbox: Whether they can be sandboxed.
    """

    def __init__(self, pool: Pool, *, can_sandbox: bool = False) -> None:
        self._pool = pool
        self._can_sandbox = can_sandbox
        self._is_busy = False

    @contextmanager
    def one(self) -> Iterator[None]:
        """Make room for a dry run, for as long as the block lasts.

        Raises:
            RequestRefused: There is one already.
        """
        if self._is_busy:
            raise RequestRefused(wire.UNAVAILABLE, "the executor is busy with another dry run")
        self._is_busy = True
        try:
            yield
        finally:
            self._is_busy = False

    async def carry_out(self, manifest: wire.Manifest, folder: RunFolder, limits: Limits) -> wire.Tried:
        """Try a bundle that lies in a folder.

        Args:
            manifest: Of the bundle.
            folder: Where its files are.
            limits: Of who has sent it.

        Raises:
            RequestRefused: Whether it can be run could not be found out.
        """
        try:
            job = make_job(_without_waiting(manifest), folder, limits, can_sandbox=self._can_sandbox, is_dry=True)
            return await self._try(job, limits)
        except (NoProcess, OSError) as error:
            raise _not_known(str(error)) from error

    async def _try(self, job: Job, limits: Limits) -> wire.Tried:
        worker = await self._pool.take()
        try:
            worker.begin(job)
            return await _told(worker, limits)
        except BaseException:
            worker.kill()
            raise
        finally:
            worker.close()
            with anyio.CancelScope(shield=True):
                await worker.wait()


def _without_waiting(manifest: wire.Manifest) -> wire.Manifest:
    """The manifest of a run that does not wait for robots."""
    options = manifest.options
    at_once = options.model_copy(update={"leasing": options.leasing.model_copy(update={"wait": None})})
    return manifest.model_copy(update={"options": at_once})


async def _told(worker: Worker, limits: Limits) -> wire.Tried:
    """What the process of a dry run tells, to its end."""
    killed = ""

    async def hold_to_usage() -> None:
        nonlocal killed
        killed = (await exceeds(worker.process, limits)).reason
        worker.kill()

    tried = wire.Tried()
    with anyio.move_on_after(LONGEST):
        async with background() as duties:
            duties.start_soon(hold_to_usage)
            async for kind, data in worker.frames():
                if kind is Frame.TRIED:
                    tried = wire.DRY_RUN.read_answer(data)
                elif kind is Frame.END:
                    return wire.Tried(end=data) if data else tried
            raise _not_known(killed or "its process died")
    raise _not_known(f"it was not over within {LONGEST:g} s")


def _not_known(reason: str) -> RequestRefused:
    return RequestRefused(Result.OPERATION_FAILED, f"the dry run came to no end: {reason}")
