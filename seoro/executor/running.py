"""An executor, put together: it listens, answers, runs what is queued, and forgets what is old."""

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

from seoro.background import background
from seoro.bridges.door import Door
from seoro.bridges.executor.messages import RunInfo, State
from seoro.bridges.revoked import Revoked
from seoro.bridges.secured import SERVING_RUNS, keys_for
from seoro.bridges.serving.emergency import stop_line
from seoro.bridges.wire.keys import NAMESPACE
from seoro.bridges.wire.message import WireError
from seoro.errors import InvalidUse
from seoro.executor import bubblewrap
from seoro.executor.emergency import Emergency
from seoro.executor.environment import for_runs
from seoro.executor.gate import Gate
from seoro.executor.limits import Policy
from seoro.executor.policy import check_permissions
from seoro.executor.queue import NoteEnd, Queue
from seoro.executor.reaching import Reached
from seoro.executor.serving import Server, days_ago
from seoro.executor.store import LOST, Finished, Store, open_store
from seoro.executor.trying import DryRuns
from seoro.executor.workers import open_pool

if TYPE_CHECKING:
    from seoro.bridges.ledger import Ledger
    from seoro.bridges.lock import Lock
    from seoro.keys.folder import Keys

AUDIT: Final = "audit.jsonl"
LAST_ANSWERS: Final = 0.3  # [s] in which watchers hear of the end of runs that the end of the executor has stopped
FORGET_PERIOD: Final = 600.0  # [s]
UNREADABLE: Final = "the executor cannot read what the run was submitted with: submit it again"

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ExecutorOptions:
    """How an executor works.

    Args:
        name: Of the executor, for its clients.
        folder: Where it keeps runs.
        listen: Endpoint at which it listens, as the hub of its clients.
        connect: Endpoint of a hub to connect to, instead.
        jobs: How many runs go on at a time.
        keep: Days for which runs that are over are kept.
        allowed: What scenarios may do that they else may not.
        keys: Folder of keys, for endpoints outside this machine; by default that of `SEORO_KEYS`, or of the user.
        policy: What those of each role may do.
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

    def __post_init__(self) -> None:
        """Resolve paths: processes of runs have working directories of their own."""
        object.__setattr__(self, "folder", self.folder.resolve())
        if self.keys is not None:
            object.__setattr__(self, "keys", self.keys.resolve())


@dataclass(frozen=True)
class Started:
    """An executor that is there.

    Attributes:
        lost: How many runs an earlier start has lost.
        name_lost: Set when it is not reached by its name any more: another has it, who has started before.
        why_name_lost: Why that is, in words.
        no_sandbox: Why its runs are not sandboxed; empty if they are.
    """

    lost: int
    name_lost: anyio.Event
    why_name_lost: str
    no_sandbox: str = ""


@asynccontextmanager
async def executing(options: ExecutorOptions) -> AsyncIterator[Started]:
    """Be an executor for as long as the block lasts, which has to end when the name is lost.

    Raises:
        InvalidUse: The folder or the keys cannot be used, or another executor has the name.
        SessionError: The endpoint does not work.
    """
    # Robots live where the executor is connected to.
    policy = options.policy.also(options.allowed, frozenset({options.connect} if options.connect else ()))
    check_permissions(policy.allowed)
    keys = keys_for(options.listen or options.connect or "", SERVING_RUNS, options.keys)
    if keys is not None and keys.identity.name != options.name:
        raise InvalidUse(
            f"the executor '{options.name}' cannot have the keys of {keys.identity}",
            help="clients trust an executor whose keys have its name: leave out `--name`",
        )
    trouble = await _sandbox_trouble(policy)
    with open_store(options.folder) as store:
        async with (
            open_pool(for_runs(policy.variables, options.keys)) as pool,
            background() as tasks,
            AsyncExitStack() as stack,
        ):
            revoked, lock = _locked(options, keys, stack)
            note_end = _note_nothing if lock is None else partial(_note, lock.ledger)
            lost = await _lose(store, note_end)
            await store.sweep()
            queue = Queue(store, pool, tasks, options.jobs, policy, note_end, can_sandbox=not trouble)
            await _queue_again(store, queue, note_end)
            emergency = Emergency(queue, options.folder)
            dry_runs = DryRuns(pool, can_sandbox=not trouble)
            server = Server(store, queue, dry_runs, options.jobs, policy, emergency, trouble)
            gate = Gate(server, policy, lock)
            stops = stack.enter_context(stop_line(lock, emergency.stop, emergency.keep, NAMESPACE))
            reached = Reached(options.name, Door(options.listen, options.connect, keys, revoked), lock)
            async with reached.answering(gate, stops, tasks), background() as duties:
                duties.start_soon(queue.work)
                duties.start_soon(queue.stop_lonely)
                duties.start_soon(queue.keep_ends)
                duties.start_soon(queue.reserve.watch)
                duties.start_soon(_forget, server, options.keep)
                try:
                    yield Started(lost, reached.name_lost, reached.why_name_lost, trouble)
                finally:
                    with anyio.CancelScope(shield=True):
                        if await queue.close(reached.why_it_ends):
                            await anyio.sleep(LAST_ANSWERS)


async def _sandbox_trouble(policy: Policy) -> str:
    """Why runs are not sandboxed; empty if they are.

    Raises:
        InvalidUse: The policy requires that they are.
    """
    if policy.sandboxes_nobody:
        return "`sandbox` is off in the policy"
    trouble = await anyio.to_thread.run_sync(bubblewrap.trouble)
    if trouble and policy.requires_sandbox:
        raise InvalidUse(f"the policy requires sandboxes, and {trouble}", help="or set `sandbox: auto` there")
    return trouble


def _locked(
    options: ExecutorOptions, keys: Keys | None, stack: AsyncExitStack
) -> tuple[Revoked | None, Lock | None]:
    """Who is revoked, and the lock, if there are keys; what has to be closed is on the stack."""
    if keys is None:
        return None, None
    from seoro.bridges.ledger import Ledger  # noqa: PLC0415 - only where there are keys
    from seoro.bridges.lock import Lock  # noqa: PLC0415 - the same
    from seoro.keys.audit import Audit  # noqa: PLC0415 - the same

    revoked, audit = Revoked(keys), Audit(options.folder / AUDIT, keys)
    stack.callback(audit.close)
    return revoked, Lock(keys, revoked, Ledger(audit))


async def _lose(store: Store, note_end: NoteEnd) -> int:
    """Take runs for lost that an executor before this one has left running; returns how many there were."""
    for info in await store.running():
        try:
            role = (await store.submission(info.run)).role
        except WireError:  # by another version of seoro
            role = ""
        await note_end(info.model_copy(update={"state": State.LOST, "reason": LOST}), role)
    return await store.give_up_running()


async def _queue_again(store: Store, queue: Queue, note_end: NoteEnd) -> None:
    """Queue what waited when an executor before this one ended; what cannot be read is an error of that run."""
    for run in await store.queued():
        info = await store.info(run)
        try:
            submission = await store.submission(run)
        except WireError as error:
            log.warning("cannot read what the run %s was submitted with: %s", run, error)
            await note_end(info.model_copy(update={"state": State.ERROR, "reason": UNREADABLE}), "")
            await store.finish(run, Finished(State.ERROR, UNREADABLE, b"", time.time()))
        else:
            queue.add(info, submission)


async def _note_nothing(_info: RunInfo, _role: str) -> None:
    """Without keys, there is no log."""


async def _note(ledger: Ledger, info: RunInfo, role: str) -> None:
    """Write down what has become of a run."""
    ledger.end(info, role)
    await anyio.to_thread.run_sync(ledger.sync)


async def _forget(server: Server, keep: float) -> None:
    while True:
        try:
            await server.forget(days_ago(keep))
        except (OSError, sqlite3.Error):  # to be tried again later
            log.exception("cannot forget what is old")
        await anyio.sleep(FORGET_PERIOD)
