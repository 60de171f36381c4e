"""Executors at one endpoint, with their runs."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

import anyio
import anyio.to_thread
from anyio.abc import TaskGroup

from seoro.bridges.executor.messages import State
from seoro.client import Client
from seoro.client.runs import RemoteRun
from seoro.concurrency.background import background
from seoro.errors import BackendError, UsageError
from seoro.ui.registry import Known, Run, RunRegistry, Status, remote_id

PERIOD: Final = 0.5  # [s] between requests for the list of runs
RETRY: Final = 3.0  # [s] between attempts to connect
PATIENCE: Final = 3.0  # [s] for answers
MOST_RUNS: Final = 1000  # of an executor, the latest ones
_LATEST: Final = 50  # runs of most requests
_ALL: Final = 20  # requests, of which one is for all runs
NO_EXECUTOR: Final = "no executor answers"
_STATUSES: Final = {
    State.QUEUED: Status.WAITING,
    State.RUNNING: Status.RUNNING,
    State.PASSED: Status.PASSED,
    State.FAILED: Status.FAILED,
    State.ERROR: Status.ERROR,
    State.CANCELLED: Status.CANCELLED,
    State.LOST: Status.KILLED,
    State.INVALID: Status.ERROR,
}


class Executors:
    """Executors at an endpoint, while the site lasts.

    Args:
        endpoint: Their endpoint; None for the default one.
        keys: Folder of keys; None for that of the environment or of the user.
        shown: Names of executors for people, where they differ.
        is_chosen: Whether the user chose the endpoint, and wants to know its problems.

    Attributes:
        endpoint: The endpoint, or None.
        is_chosen: See above.
        client: The client; None while nothing answers at the endpoint.
        names: Names of the reachable executors.
        problem: Reason for missing executors; empty otherwise, and before the first attempt.
        silent: Reasons of reachable executors that do not answer, by name.
        lost: Names of executors that were reachable before.
        tried: Set after the first attempt.
        on_change: Called when `names` changes.
    """

    def __init__(
        self,
        endpoint: str | None,
        keys: Path | None,
        shown: Mapping[str, str],
        *,
        is_chosen: bool = True,
    ) -> None:
        self.endpoint = endpoint
        self.is_chosen = is_chosen
        self.client: Client | None = None
        self.names: tuple[str, ...] = ()
        self.problem = ""
        self.silent: dict[str, str] = {}
        self.lost: set[str] = set()
        self.tried = anyio.Event()
        self.on_change: Callable[[], object] = lambda: None
        self._keys = keys
        self._shown = shown

    def shown(self, name: str) -> str:
        """Return the name of an executor for people."""
        return self._shown.get(name, name)

    async def watch(self, registry: RunRegistry) -> None:
        """Stay connected, and keep the runs of a registry up to date, without end."""
        while True:
            try:
                async with Client(self.endpoint, self._keys, PATIENCE) as client, background() as tasks:
                    self.client = client
                    await self._follow_all(client, registry, tasks)
            except (UsageError, BackendError) as error:
                self.problem = error.message if isinstance(error, UsageError) else str(error)
            finally:
                self.lost |= set(self.names)
                self.client, self.names = None, ()
            self.tried.set()
            await anyio.sleep(RETRY)

    async def _follow_all(self, client: Client, registry: RunRegistry, tasks: TaskGroup) -> None:
        """Follow each executor in a task, so that a silent one delays no other."""
        followed: dict[str, anyio.CancelScope] = {}
        while True:
            names = tuple(await client.executors())
            for name in followed.keys() - set(names):
                followed.pop(name).cancel()
            for name in [each for each in names if each not in followed]:
                followed[name] = anyio.CancelScope()
                tasks.start_soon(self._follow, client, name, registry, followed[name])
            self.problem = "" if names else f"{NO_EXECUTOR} at {client.endpoint}"
            self.lost = (self.lost | set(self.names)) - set(names)
            if names != self.names:
                self.names = names
                self.on_change()
            self.tried.set()
            await anyio.sleep(PERIOD)

    async def _follow(self, client: Client, name: str, registry: RunRegistry, scope: anyio.CancelScope) -> None:
        with scope:
            for number in itertools.count():
                try:
                    await self._update(client, name, registry, is_whole=number % _ALL == 0)
                    self.silent.pop(name, None)
                except (UsageError, BackendError) as error:
                    self.silent[name] = error.message if isinstance(error, UsageError) else str(error)
                await anyio.sleep(PERIOD)

    async def _update(self, client: Client, name: str, registry: RunRegistry, *, is_whole: bool) -> None:
        place = self.shown(name)
        known = {each.run.id: each.run for each in registry.all() if each.run.place == place}
        runs = await client.runs(name, MOST_RUNS if is_whole else _LATEST)
        found = [Known(describe(run, place, _named(known.get(remote_id(run.id)))), run) for run in runs]
        registry.update(found, known.keys() - {each.run.id for each in found} if is_whole else ())


def describe(run: RemoteRun, place: str, scenario: str = "") -> Run:
    """Describe a run of an executor.

    Args:
        run: The run.
        place: Name of its executor for people.
        scenario: Name of its scenario until the executor reports it; empty if unknown.
    """
    info = run.info
    return Run(
        id=remote_id(run.id),
        place=place,
        kind="executor",
        scenario=info.scenario or scenario,
        file=info.file,
        status=_STATUSES[info.state],
        reason=info.reason,
        submitted=info.submitted,
        started=info.started,
        ended=info.ended,
        by=info.by,
        robots=info.robots,
        waits=info.waits,
        position=info.place,
        may_stop=not info.state.is_final,
    )


def _named(before: Run | None) -> str:
    return "" if before is None else before.scenario
