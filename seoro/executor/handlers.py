"""Handlers of requests: submissions, states, records and files of runs."""

from __future__ import annotations

import logging
import secrets
import shutil
import sqlite3
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Any, Final

import anyio
import anyio.to_thread

from seoro import __version__
from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.messages import RunInfo
from seoro.bridges.executor.probing import EndpointReport, Hop, ProbeReport, ProbeRequest
from seoro.bridges.launch import can_film, is_installed, known_simulators
from seoro.bridges.wire import Empty, LabResult, Message, ReleaseStop, Result, Verb
from seoro.bridges.wire.refusal import RequestRefused
from seoro.bundle.paths import InvalidPath, check_path
from seoro.concurrency.gathering import gather
from seoro.errors import UsageError
from seoro.executor.emergency_stop import EmergencyStopSwitch
from seoro.executor.limits import Policy, check_submission
from seoro.executor.permissions import vet_endpoint
from seoro.executor.runs.active_run import OVER
from seoro.executor.runs.beginnings import Beginnings
from seoro.executor.runs.dry_run import DryRuns
from seoro.executor.runs.queue import Queue
from seoro.executor.runs.records import is_news, list_outputs, read_lines, read_printed, watch_records
from seoro.executor.storage.blobs import Blobs, make_room
from seoro.executor.storage.intake import Intake, rejected_bundle
from seoro.executor.storage.run_folder import open_left
from seoro.executor.storage.store import Store
from seoro.lab.probes import probe

LOOKS: Final = 20  # exchanges with each node to measure its clock

NOBODY: Final = ""  # owner of the blobs of clients without keys

Handler = Callable[[Any], Awaitable[Message | None]]

log = logging.getLogger(__name__)


class RequestHandlers:
    """Carries out the requests to an executor, each by the method that is named like its verb.

    Args:
        store: Storage of runs.
        queue: Queue of runs that are not over.
        dry_runs: Executes dry runs.
        jobs: Number of runs at a time.
        policy: Limits of clients.
        emergency: Emergency stop of the executor.
        no_sandbox: Reason why runs are not sandboxed; empty if they are.
    """

    def __init__(
        self,
        store: Store,
        queue: Queue,
        dry_runs: DryRuns,
        jobs: int,
        policy: Policy,
        emergency: EmergencyStopSwitch,
        no_sandbox: str = "",
    ) -> None:
        self._store = store
        self._dry_runs = dry_runs
        self._queue = queue
        self._blobs = Blobs(store.blobs)
        self._info = wire.ExecutorInfo(
            version=__version__,
            jobs=jobs,
            allowed=tuple(sorted(policy.allowed)),
            simulators=tuple(name for name in known_simulators() if is_installed(name)),
            films=can_film(),
            no_sandbox=no_sandbox,
        )
        self._policy = policy
        self._emergency = emergency
        self._intake = Intake(self._blobs)
        self._submitting = anyio.Lock()  # parts of blobs
        self._beginnings = Beginnings(store.folder)
        self._reading = anyio.Lock()  # beginnings of traces

    async def carry_out(
        self, verb: Verb[Any, Any], request: Message, send: Callable[[bytes], None]
    ) -> Message | None:
        """Carry out a request.

        Args:
            verb: Verb of the request.
            request: The request.
            send: Sends a part of the reply before the rest.

        Raises:
            RequestRefused: The request failed, or needs keys.
        """
        if isinstance(request, wire.AskRecords):
            return await self.records(request, send)
        handler: Handler | None = getattr(self, verb.name, None)
        if handler is None:
            raise RequestRefused(
                Result.FEATURE_UNSUPPORTED, f"the request `{verb.name}` needs an executor with keys"
            )
        return await handler(request)

    async def remove_old(self, before: float) -> None:
        """Remove runs that ended before a time, and blobs that were not used since."""
        for run in await self._store.over(before):
            try:
                await self._store.remove(run)
            except (OSError, RecursionError) as error:  # deeply nested folders
                log.warning("cannot remove the files of the run %s: %s", run, error)
        await anyio.to_thread.run_sync(self._blobs.remove_old, before)

    # -------------------------------------------------------- submissions

    async def describe(self, _request: Empty) -> wire.ExecutorInfo:
        received = time.time()
        free = shutil.disk_usage(self._store.blobs).free
        now = {
            "running": self._queue.running,
            "waiting": self._queue.waiting,
            "free": free,
            "stopped": self._emergency.reason,
        }
        return self._info.model_copy(update={**now, "received": received, "sent": time.time()})

    async def look(self, request: ProbeRequest) -> ProbeReport:
        """Examine the endpoints that runs of the client may reach, with the keys of the executor."""
        limits = self._policy.of(request.role)

        async def probe_endpoint(endpoint: str) -> EndpointReport:
            try:
                vet_endpoint(endpoint, limits.allowed, limits.reached)
            except UsageError as error:
                return EndpointReport(endpoint=endpoint, ends_at=Hop.POLICY, why=str(error), advice=error.help)
            return await probe(endpoint, exchanges=LOOKS)

        found = {each.endpoint: each for each in await gather(probe_endpoint, dict.fromkeys(request.endpoints))}
        return ProbeReport(places=tuple(found[endpoint] for endpoint in request.endpoints))

    async def missing_blobs(self, request: wire.Hashes) -> wire.Hashes:
        return wire.Hashes(hashes=self._blobs.missing(request.hashes))

    async def put_blob(self, request: wire.PutBlob) -> None:
        async with self._submitting:
            try:
                await anyio.to_thread.run_sync(self._put, request)
            except OSError as error:  # a full disk
                raise rejected_bundle(error.strerror or str(error)) from error

    def _put(self, request: wire.PutBlob) -> None:
        limits = self._policy.of(request.role)
        make_room(self._blobs, self._store.blobs, len(request.data), limits, {request.hash})
        self._blobs.put(request, limits.blob_quota)

    async def submit(self, request: wire.Submission) -> RunInfo:
        limits = self._policy.of(request.role)
        async with self._intake.one(request.run, request.by):
            with suppress(KeyError):
                return await self._store.info(request.run)
            if self._emergency.reason:
                raise RequestRefused(
                    LabResult.STOPPED,
                    f"the executor accepts no runs: {self._emergency.reason}; release it by "
                    "`seoro lab release --all`",
                )
            _check_version(request.campaign)
            others = self._queue.waiting_of(request.by) + self._intake.arriving_of(request.by) - 1
            check_submission(request, limits, others)
            await self._intake.lay_out(request.manifest, self._store.folder(request.run), limits)
            try:
                info = await self._store.add(request)
            except sqlite3.Error as error:  # a full disk
                shutil.rmtree(self._store.folder(request.run).path, ignore_errors=True)
                raise rejected_bundle(str(error)) from error
            self._queue.add(info, request)
        return self._queue.with_place(info)

    async def dry_run(self, request: wire.DryRun) -> wire.DryRunResult:
        limits = self._policy.of(request.role)
        check_submission(request, limits, self._queue.waiting_of(request.by))
        folder = self._store.folder(secrets.token_hex(16))  # never the folder of a run
        with self._dry_runs.one():
            try:
                await self._intake.lay_out(request.manifest, folder, limits)
                return await self._dry_runs.execute(request.manifest, folder, limits)
            finally:
                shutil.rmtree(folder.path, ignore_errors=True)
                with anyio.CancelScope(shield=True):
                    async with self._submitting:  # no other submission is about to use them
                        self._blobs.drop(request.sent, request.by if request.role else NOBODY)

    async def release_stop(self, request: ReleaseStop) -> None:
        await self._emergency.release(request)

    # -------------------------------------------------------- runs

    async def list_runs(self, request: wire.ListRuns) -> wire.Runs:
        runs = await self._store.youngest(request.limit, request.prefix)
        placed = tuple(map(self._queue.with_place, runs))
        async with self._reading:
            return wire.Runs(runs=await anyio.to_thread.run_sync(self._beginnings.add_to, placed))

    async def _known(self, run: str) -> RunInfo:
        live = self._queue.get(run)
        if live is not None:
            return self._queue.with_place(live.info)
        try:
            return await self._store.info(run)
        except KeyError:
            raise RequestRefused(Result.NOT_FOUND, f"unknown run {run}") from None

    async def get_run(self, request: wire.OneRun) -> wire.Details:
        info = await self._known(request.run)
        return wire.Details(info=info, end=await self._store.end(request.run))

    async def stop_run(self, request: wire.StopRun) -> RunInfo:
        await self._known(request.run)
        if self._queue.get(request.run) is not None:
            await self._queue.stop(request.run, request.reason or "stopped by a client")
        return await self._known(request.run)

    async def give_runs(self, request: wire.PlannedRuns) -> None:
        live = self._queue.get(request.run)
        if live is not None:
            live.give_runs(request)
            return
        await self._known(request.run)
        raise RequestRefused(Result.INCORRECT_STATE, "the worker of the campaign has ended")

    async def emit_event(self, request: wire.EmitEvent) -> wire.Emitted:
        live = self._queue.get(request.run)
        if live is not None:
            return await live.emit(request)
        await self._known(request.run)
        raise RequestRefused(wire.NOT_EMITTED, OVER)

    async def records(self, request: wire.AskRecords, send: Callable[[bytes], None]) -> wire.Records:
        live, at = self._queue.get(request.run), request.at
        if live is not None:
            if request.keeps_alive:
                live.note_client()
            if request.in_parts:
                at = await watch_records(live, request, self._store.folder(request.run).log, send)
            else:
                with suppress(TimeoutError):
                    await live.changes.wait_for(lambda: is_news(live, request), request.wait)
            if request.keeps_alive:
                live.note_client()
        info = self._queue.with_place(live.info) if live is not None else await self._known(request.run)
        folder = self._store.folder(request.run)
        lines, is_last = read_lines(folder.trace, at)
        printed, is_all = read_printed(folder.log, request.printed_at)
        is_complete = is_last and is_all and info.state.is_final
        end = await self._store.end(request.run) if is_complete and request.in_parts else b""
        return wire.Records(
            lines=lines, at=at + len(lines), is_complete=is_complete, info=info, end=end, printed=printed
        )

    async def list_files(self, request: wire.OneRun) -> wire.Outputs:
        await self._known(request.run)
        output = self._store.folder(request.run).output
        return wire.Outputs(files=tuple(await anyio.to_thread.run_sync(list, list_outputs(output))))

    async def read_file(self, request: wire.ReadFile) -> wire.FilePart:
        await self._known(request.run)
        output = self._store.folder(request.run).output
        try:
            path = output / check_path(request.path)
            with open_left(path, output) as file:
                file.seek(request.offset)
                return wire.FilePart(data=file.read(wire.CHUNK))
        except FileNotFoundError:
            raise RequestRefused(Result.NOT_FOUND, f"unknown output file {request.path!r} of the run") from None
        except (InvalidPath, OSError) as error:
            raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error

    async def remove_run(self, request: wire.OneRun) -> None:
        info = await self._known(request.run)
        if not info.state.is_final:
            raise RequestRefused(Result.INCORRECT_STATE, f"the run is {info.state.value}: stop it first")
        await self._store.remove(request.run)
        self._queue.forget(request.run)


def _check_version(campaign: wire.CampaignWorker | None) -> None:
    """Check that a campaign began with this version of seoro.

    Raises:
        RequestRefused: It began with another one.
    """
    if campaign is not None and campaign.version != __version__:
        raise RequestRefused(
            Result.FEATURE_UNSUPPORTED,
            f"the campaign began with seoro {campaign.version}, this executor has {__version__}: the runs of a "
            "campaign need one version",
        )


def days_ago(days: float) -> float:
    """Return the time some days ago [s since 1970]."""
    return time.time() - days * 86_400.0
