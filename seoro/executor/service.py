"""The executor service: listens, answers requests, runs queued scenarios and removes old runs."""

from __future__ import annotations

import logging
import sqlite3
import time
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

import anyio
import anyio.to_thread

from seoro.bridges.executor.messages import RunInfo, State
from seoro.bridges.serving.emergency import stop_thread
from seoro.bridges.wire.keys import NAMESPACE
from seoro.bridges.wire.message import WireError
from seoro.concurrency.background import background
from seoro.errors import UsageError
from seoro.executor.authorizer import Authorizer
from seoro.executor.emergency_stop import EmergencyStopSwitch
from seoro.executor.end_notifier import EndNotifier
from seoro.executor.endpoint import ExecutorEndpoint
from seoro.executor.handlers import RequestHandlers, days_ago
from seoro.executor.limits import Policy
from seoro.executor.permissions import check_permissions
from seoro.executor.process.environment import for_runs
from seoro.executor.process.pool import open_pool
from seoro.executor.runs.dry_run import DryRuns
from seoro.executor.runs.queue import NoteEnd, Queue
from seoro.executor.sandbox import bubblewrap
from seoro.executor.storage.store import LOST, Finished, Store, open_store
from seoro.notifications.addresses import Address
from seoro.security.network.endpoint_keys import SERVING_RUNS, keys_for
from seoro.security.network.listener import Listener
from seoro.security.network.revocation_monitor import RevocationMonitor

if TYPE_CHECKING:
    from seoro.security.keys.folder import Keys
    from seoro.security.network.audit_trail import AuditTrail
    from seoro.security.network.node_identity import NodeIdentity

AUDIT: Final = "audit.jsonl"
LAST_ANSWERS: Final = 0.3  # [s] to report the end of stopped runs to their clients
CLEANUP_PERIOD: Final = 600.0  # [s]
UNREADABLE: Final = "the executor cannot read the stored submission: submit the run again"

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ExecutorOptions:
    """Settings of an executor.

    Args:
        name: Name of the executor, for its clients.
        folder: Folder for runs.
        listen: Endpoint to listen at, as the hub of clients.
        connect: Endpoint of a hub to connect to, in place of `listen`.
        jobs: Number of runs at a time.
        keep: Time to keep finished runs [days].
        allowed: Names of permissions for scenarios (`permissions.py`).
        keys: Folder of keys, for endpoints outside this machine; by default `SEORO_KEYS` or that of the user.
        policy: Limits of each role.
        notify: URLs that receive the ends of runs.
    """

    name: str
    folder: Path
    listen: str | None = None
    connect: str | None = None
    jobs: int = 1
    keep: float = 30.0
    allowed: frozenset[str] = frozenset()
    keys: Path | None = None
    policy: Policy = field(default_factory=Policy)
    notify: tuple[Address, ...] = ()

    def __post_init__(self) -> None:
        """Make paths absolute: processes of runs have other working directories."""
        object.__setattr__(self, "folder", self.folder.resolve())
        if self.keys is not None:
            object.__setattr__(self, "keys", self.keys.resolve())


@dataclass(frozen=True)
class Started:
    """A started executor.

    Attributes:
        lost: Number of runs that were interrupted by the end of the previous executor.
        name_lost: Set when an older executor has the same name.
        why_name_lost: Message for that.
        no_sandbox: Reason why runs are not sandboxed; empty if they are.
    """

    lost: int
    name_lost: anyio.Event
    why_name_lost: str
    no_sandbox: str = ""


@asynccontextmanager
async def open_executor(options: ExecutorOptions) -> AsyncIterator[Started]:
    """Run an executor while the block lasts; the block has to end when the name is lost.

    Raises:
        UsageError: The folder or the keys are invalid, or another executor has the name.
        SessionError: The endpoint cannot be opened.
    """
    # Robots live where the executor is connected to.
    policy = options.policy.also(options.allowed, frozenset({options.connect} if options.connect else ()))
    check_permissions(policy.allowed)
    keys = keys_for(options.listen or options.connect or "", SERVING_RUNS, options.keys)
    if keys is not None and keys.identity.name != options.name:
        raise UsageError(
            f"the keys of {keys.identity} do not fit the executor '{options.name}'",
            help="leave out `--name`: an executor has the name in its keys",
        )
    trouble = await _sandbox_trouble(policy)
    with open_store(options.folder) as store:
        async with (
            open_pool(for_runs(policy.variables, options.keys)) as pool,
            background() as tasks,
            AsyncExitStack() as stack,
        ):
            revoked, identity = _locked(options, keys, stack)
            notifier = stack.enter_context(EndNotifier(options.name, options.notify))
            note_end = partial(_note, notifier, None if identity is None else identity.audit_trail)
            lost = await _finish_interrupted(store, note_end)
            await store.sweep()
            queue = Queue(store, pool, tasks, options.jobs, policy, note_end, can_sandbox=not trouble)
            await _queue_again(store, queue, note_end)
            emergency = EmergencyStopSwitch(queue, options.folder)
            dry_runs = DryRuns(pool, can_sandbox=not trouble)
            server = RequestHandlers(store, queue, dry_runs, options.jobs, policy, emergency, trouble)
            authorizer = Authorizer(server, policy, identity)
            stops = stack.enter_context(stop_thread(identity, emergency.stop, emergency.keep, NAMESPACE))
            reached = ExecutorEndpoint(
                options.name, Listener(options.listen, options.connect, keys, revoked), identity
            )
            async with reached.answering(authorizer, stops, tasks), background() as duties:
                duties.start_soon(notifier.work)
                duties.start_soon(queue.work)
                duties.start_soon(queue.stop_lonely)
                duties.start_soon(queue.shift_workers)
                duties.start_soon(queue.ends.retry_forever)
                duties.start_soon(queue.reserve.watch)
                duties.start_soon(_remove_old, server, options.keep)
                try:
                    yield Started(lost, reached.name_lost, reached.why_name_lost, trouble)
                finally:
                    with anyio.CancelScope(shield=True):
                        if await queue.close(reached.why_it_ends):
                            await anyio.sleep(LAST_ANSWERS)
                        await notifier.close()


async def _sandbox_trouble(policy: Policy) -> str:
    """Return the reason why runs are not sandboxed; empty if they are.

    Raises:
        UsageError: The policy requires sandboxes, which are unavailable.
    """
    if policy.sandboxes_nobody:
        return "`sandbox` is off in the policy"
    trouble = await anyio.to_thread.run_sync(bubblewrap.trouble)
    if trouble and policy.requires_sandbox:
        raise UsageError(f"the policy requires sandboxes, but {trouble}", help="or set `sandbox: auto` there")
    return trouble


def _locked(
    options: ExecutorOptions, keys: Keys | None, stack: AsyncExitStack
) -> tuple[RevocationMonitor | None, NodeIdentity | None]:
    """Return the monitor of revoked keys and the identity of the executor; None without keys."""
    if keys is None:
        return None, None
    from seoro.security.network.audit_trail import AuditTrail  # noqa: PLC0415 - only where there are keys
    from seoro.security.network.node_identity import NodeIdentity  # noqa: PLC0415 - the same
    from seoro.security.signing.audit_log import AuditLog  # noqa: PLC0415 - the same

    revoked, audit = RevocationMonitor(keys), AuditLog(options.folder / AUDIT, keys)
    stack.callback(audit.close)
    return revoked, NodeIdentity(keys, revoked, AuditTrail(audit))


async def _finish_interrupted(store: Store, note_end: NoteEnd) -> int:
    """Finish the runs of a previous executor that died as lost; returns their number."""
    for info in await store.running():
        try:
            role = (await store.submission(info.run)).role
        except WireError:  # by another version of seoro
            role = ""
        await note_end(info.model_copy(update={"state": State.LOST, "reason": LOST}), role)
    return await store.mark_lost()


async def _queue_again(store: Store, queue: Queue, note_end: NoteEnd) -> None:
    """Queue the runs that waited at the end of the previous executor; unreadable ones end as errors."""
    for run in await store.queued():
        info = await store.info(run)
        try:
            submission = await store.submission(run)
        except WireError as error:
            log.warning("cannot read the submission of the run %s: %s", run, error)
            await note_end(info.model_copy(update={"state": State.ERROR, "reason": UNREADABLE}), "")
            await store.finish(run, Finished(State.ERROR, UNREADABLE, b"", time.time()))
        else:
            queue.add(info, submission)


async def _note(notifier: EndNotifier, audit_trail: AuditTrail | None, info: RunInfo, role: str) -> None:
    """Notify of the end of a run, and record it in the audit log; executors without keys have none."""
    notifier.note(info)
    if audit_trail is not None:
        audit_trail.record_run(info, role)
        await anyio.to_thread.run_sync(audit_trail.sync)


async def _remove_old(server: RequestHandlers, keep: float) -> None:
    while True:
        try:
            await server.remove_old(days_ago(keep))
        except (OSError, sqlite3.Error):  # retried later
            log.exception("cannot remove old runs")
        await anyio.sleep(CLEANUP_PERIOD)
