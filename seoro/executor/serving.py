"""Answers clients: takes bundles and runs in, and tells what becomes of them."""

from __future__ import annotations

import logging
import os
import secrets
import shutil
import sqlite3
import time
from collections.abc import Awaitable, Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import anyio
import anyio.to_thread

from seoro import __version__
from seoro.background import background
from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.messages import RunInfo
from seoro.bridges.executor.sight import LOOK, Hop, Look, PlaceSeen, Sight
from seoro.bridges.launch import can_film, is_installed, known_simulators
from seoro.bridges.serving.answering import decoded
from seoro.bridges.wire import RELEASE_STOP, Empty, LabResult, Message, Result, Verb, encode
from seoro.bridges.wire.refusal import RequestRefused, listed
from seoro.bundle.places import InvalidPlace, check_place
from seoro.errors import InvalidUse
from seoro.executor.blobs import Blobs
from seoro.executor.emergency import Emergency
from seoro.executor.intake import Intake, not_taken
from seoro.executor.left import open_left
from seoro.executor.limits import Policy, check_submission
from seoro.executor.live import LiveRun
from seoro.executor.policy import vet_endpoint
from seoro.executor.queue import Queue
from seoro.executor.room import make_room
from seoro.executor.store import Store
from seoro.executor.trying import DryRuns
from seoro.executor.watching import Watch, size_of, until_printed
from seoro.lab.examining import examine

LOOKS: Final = 20  # at each node, for who asks what is seen from here
PART: Final = wire.CHUNK // 2  # [bytes] of a trace in one answer, unless a line is longer

NOBODY: Final = ""  # whose all is that those without keys send

Handler = Callable[[Any], Awaitable[Message]]

log = logging.getLogger(__name__)


class Server:
    """Carries out requests.

    Args:
        store: Of runs.
        queue: Of those that are not over.
        dry_runs: Those that are only tried.
        jobs: How many go on at a time.
        policy: What submitters may.
        emergency: Stops them all.
        no_sandbox: Why runs are not sandboxed; empty if they are.
    """

    def __init__(
        self,
        store: Store,
        queue: Queue,
        dry_runs: DryRuns,
        jobs: int,
        policy: Policy,
        emergency: Emergency,
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
        handlers: Mapping[Verb[Any, Any], Handler] = {  # beside `_records`, which has more to say than one answer
            wire.DESCRIBE: self._describe,
            wire.MISSING_BLOBS: self._missing_blobs,
            wire.PUT_BLOB: self._put_blob,
            wire.SUBMIT: self._submit,
            wire.DRY_RUN: self._dry_run,
            wire.LIST_RUNS: self._list_runs,
            wire.GET_RUN: self._get_run,
            wire.STOP_RUN: self._stop_run,
            wire.LIST_FILES: self._list_files,
            wire.READ_FILE: self._read_file,
            wire.REMOVE_RUN: self._remove_run,
            LOOK: self._look,
            RELEASE_STOP: emergency.release,
        }
        self._handlers = MappingProxyType({verb.name: (verb, handler) for verb, handler in handlers.items()})

    async def carry_out(self, name: str, payload: bytes, send: Callable[[bytes], None]) -> Message:
        """Carry out a verb.

        Args:
            name: Of the verb.
            payload: The request.
            send: Sends a part of the answer before the rest.

        Raises:
            RequestRefused: There is none of that name, or it cannot be carried out.
        """
        if name == wire.RECORDS.name:
            return await self._records(decoded(wire.RECORDS, payload), send)
        if name not in self._handlers:
            known = listed((*self._handlers, wire.RECORDS.name))
            raise RequestRefused(
                Result.FEATURE_UNSUPPORTED,
                f"this executor is of seoro {__version__} and cannot be asked for {name!r}: known are {known}",
            )
        verb, handler = self._handlers[name]
        return await handler(decoded(verb, payload))

    async def forget(self, before: float) -> None:
        """Remove runs that ended before a time, and blobs that were not used since; what cannot go stays."""
        for run in await self._store.over(before):
            try:
                await self._store.remove(run)
            except (OSError, RecursionError) as error:  # of folders deep within each other, which a run has left
                log.warning("cannot remove the files of the run %s: %s", run, error)
        await anyio.to_thread.run_sync(self._blobs.forget, before)

    # -------------------------------------------------------- taking runs in

    async def _describe(self, _request: Empty) -> wire.ExecutorInfo:
        received = time.time()
        free = shutil.disk_usage(self._store.blobs).free
        now = {
            "running": self._queue.running,
            "waiting": self._queue.waiting,
            "free": free,
            "stopped": self._emergency.reason,
        }
        return self._info.model_copy(update={**now, "received": received, "sent": time.time()})

    async def _look(self, request: Look) -> Sight:
        """What runs of who asks would see of a lab, with the keys of the executor."""
        limits = self._policy.of(request.role)
        found: dict[str, PlaceSeen] = {}

        async def look_at(endpoint: str) -> None:
            try:
                vet_endpoint(endpoint, limits.allowed, limits.reached)
            except InvalidUse as error:
                seen = PlaceSeen(endpoint=endpoint, ends_at=Hop.POLICY, why=str(error), advice=error.help)
            else:
                seen = await examine(endpoint, exchanges=LOOKS)
            found[endpoint] = seen

        async with anyio.create_task_group() as tasks:
            for endpoint in dict.fromkeys(request.endpoints):
                tasks.start_soon(look_at, endpoint)
        return Sight(places=tuple(found[endpoint] for endpoint in request.endpoints))

    async def _missing_blobs(self, request: wire.Hashes) -> wire.Hashes:
        return wire.Hashes(hashes=self._blobs.missing(request.hashes))

    async def _put_blob(self, request: wire.PutBlob) -> Empty:
        async with self._submitting:
            try:
                await anyio.to_thread.run_sync(self._put, request)
            except OSError as error:  # a full disk
                raise not_taken(error.strerror or str(error)) from error
        return Empty()

    def _put(self, request: wire.PutBlob) -> None:
        limits = self._policy.of(request.role)
        make_room(self._blobs, self._store.blobs, len(request.data), limits, {request.hash})
        self._blobs.put(request, limits.kept_of_one)

    async def _submit(self, request: wire.Submission) -> RunInfo:
        limits = self._policy.of(request.role)
        async with self._intake.one(request.run, request.by):
            with suppress(KeyError):
                return await self._store.info(request.run)
            if self._emergency.reason:
                raise RequestRefused(
                    LabResult.STOPPED,
                    f"the executor takes no run: {self._emergency.reason}; `seoro lab release --all` ends that",
                )
            others = self._queue.waiting_of(request.by) + self._intake.arriving_of(request.by) - 1
            check_submission(request, limits, others)
            await self._intake.lay_out(request.manifest, self._store.folder(request.run), limits)
            try:
                info = await self._store.add(request)
            except sqlite3.Error as error:  # a full disk
                shutil.rmtree(self._store.folder(request.run).path, ignore_errors=True)
                raise not_taken(str(error)) from error
            self._queue.add(info, request)
        return self._queue.placed(info)

    async def _dry_run(self, request: wire.DryRun) -> wire.Tried:
        limits = self._policy.of(request.role)
        check_submission(request, limits, self._queue.waiting_of(request.by))
        folder = self._store.folder(secrets.token_hex(16))  # not that of a run, whatever the client says
        with self._dry_runs.one():
            try:
                await self._intake.lay_out(request.manifest, folder, limits)
                return await self._dry_runs.carry_out(request.manifest, folder, limits)
            finally:
                shutil.rmtree(folder.path, ignore_errors=True)
                with anyio.CancelScope(shield=True):
                    async with self._submitting:  # nobody else is about to use them
                        self._blobs.drop(request.sent, request.by if request.role else NOBODY)

    # -------------------------------------------------------- telling of runs

    async def _list_runs(self, request: wire.ListRuns) -> wire.Runs:
        runs = await self._store.youngest(request.limit, request.prefix)
        return wire.Runs(runs=tuple(map(self._queue.placed, runs)))

    async def _known(self, run: str) -> RunInfo:
        live = self._queue.get(run)
        if live is not None:
            return self._queue.placed(live.info)
        try:
            return await self._store.info(run)
        except KeyError:
            raise RequestRefused(Result.NOT_FOUND, f"there is no run {run}") from None

    async def _get_run(self, request: wire.OneRun) -> wire.Details:
        info = await self._known(request.run)
        return wire.Details(info=info, end=await self._store.end(request.run))

    async def _stop_run(self, request: wire.StopRun) -> RunInfo:
        await self._known(request.run)
        if self._queue.get(request.run) is not None:
            await self._queue.stop(request.run, request.reason or "stopped by a client")
        return await self._known(request.run)

    async def _records(self, request: wire.AskRecords, send: Callable[[bytes], None]) -> wire.Records:
        live, at = self._queue.get(request.run), request.at
        if live is not None:
            if request.keeps_alive:
                live.note_watcher()
            if request.in_parts:
                at = await _watch(live, request, self._store.folder(request.run).log, send)
            else:
                with suppress(TimeoutError):
                    await live.changes.wait_for(lambda: _is_news(live, request), request.wait)
            if request.keeps_alive:
                live.note_watcher()
        info = self._queue.placed(live.info) if live is not None else await self._known(request.run)
        folder = self._store.folder(request.run)
        lines, is_last = _lines(folder.trace, at)
        printed, is_all = _printed(folder.log, request.printed_at)
        is_complete = is_last and is_all and info.state.is_final
        end = await self._store.end(request.run) if is_complete and request.in_parts else b""
        return wire.Records(
            lines=lines, at=at + len(lines), is_complete=is_complete, info=info, end=end, printed=printed
        )

    async def _list_files(self, request: wire.OneRun) -> wire.Outputs:
        await self._known(request.run)
        output = self._store.folder(request.run).output
        return wire.Outputs(files=tuple(await anyio.to_thread.run_sync(list, _outputs(output))))

    async def _read_file(self, request: wire.ReadFile) -> wire.FilePart:
        await self._known(request.run)
        output = self._store.folder(request.run).output
        try:
            path = output / check_place(request.path)
            with open_left(path, output) as file:
                file.seek(request.offset)
                return wire.FilePart(data=file.read(wire.CHUNK))
        except FileNotFoundError:
            raise RequestRefused(Result.NOT_FOUND, f"the run has left no file {request.path!r}") from None
        except (InvalidPlace, OSError) as error:
            raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error

    async def _remove_run(self, request: wire.OneRun) -> Empty:
        info = await self._known(request.run)
        if not info.state.is_final:
            raise RequestRefused(Result.INCORRECT_STATE, f"the run is {info.state.value}: stop it first")
        await self._store.remove(request.run)
        self._queue.forget(request.run)
        return Empty()


def _is_news(live: LiveRun, request: wire.AskRecords) -> bool:
    """Whether there is something that whoever asks does not know."""
    info = live.info
    is_known = (info.state, bool(info.announcement)) == (request.state, request.is_announced)
    return live.size > request.at or not is_known or request.waits not in (None, info.waits)


async def _watch(live: LiveRun, request: wire.AskRecords, log: Path, send: Callable[[bytes], None]) -> int:
    """Send records as they come, until there is something else to tell; returns up to where they were sent."""

    def send_part(start: int, lines: bytes) -> None:
        send(encode(wire.NewRecords(lines=lines, at=start + len(lines))))

    watch = Watch(request.at, wire.WINDOW, send_part)
    if not _is_news(live, request):
        with live.watches.having(watch), anyio.move_on_after(request.wait):
            async with background() as looking:
                if request.printed_at is not None:
                    looking.start_soon(_end_when_printed, watch, log, request.printed_at)
                await watch.over.wait()
    return watch.at


async def _end_when_printed(watch: Watch, log: Path, at: int) -> None:
    await until_printed(log, at)
    watch.over.set()


def _lines(trace: Path, at: int) -> tuple[bytes, bool]:
    """Whole lines of a trace from a byte on, and whether there are no more."""
    try:
        with trace.open("rb") as file:
            size = os.fstat(file.fileno()).st_size
            file.seek(at)
            data = file.read(PART)
            if b"\n" not in data:
                data += file.readline()
            whole = data[: data.rfind(b"\n") + 1]
            # What an executor that died has left half written is no line, and stays out.
            return whole, at + len(data) >= size
    except FileNotFoundError:  # it has not begun
        return b"", True


def _printed(log: Path, at: int | None) -> tuple[bytes, bool]:
    """What was printed from a byte on, and whether there is no more; nothing for those who do not ask for it."""
    if at is None or size_of(log) <= at:
        return b"", True
    try:
        with open_left(log, log.parent) as file:
            file.seek(at)
            data = file.read(PART)
            return data, at + len(data) >= os.fstat(file.fileno()).st_size
    except OSError:  # it is gone, or the run has put something else in its place
        return b"", True


def _outputs(folder: Path) -> Iterator[wire.OutputInfo]:
    """The files in and below a folder; none that links lead to."""
    for place, _, files in os.walk(folder):
        for name in files:
            path = Path(place, name)
            if path.is_file() and not path.is_symlink():
                yield wire.OutputInfo(path=path.relative_to(folder).as_posix(), size=path.stat().st_size)


def days_ago(days: float) -> float:
    """A time, in seconds since 1970."""
    return time.time() - days * 86_400.0
