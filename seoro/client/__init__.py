"""Running scenarios on executors, across the network, from Python.

    async with seoro.Client() as client:
        run = await client.submit("lab-a", "maze.osc", seed=7)
        async for record in run.records():
            ...
        verdict = await run.result()
        await run.fetch("out")

A run lives at its executor: it goes on when the client is gone, and any client that knows its id may follow it
from the first record on, stop it, or fetch what it has left.
"""

from __future__ import annotations

import math
import os
import secrets
from collections.abc import Iterable, Sequence
from contextlib import AsyncExitStack
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Self, Unpack

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.addresses import ENDPOINT
from seoro.bridges.executor.asking import PATIENCE, Executor
from seoro.bridges.executor.clocks import Clock, describe
from seoro.bridges.executor.finding import find_executor, find_executors, how_to_see_some
from seoro.bridges.secured import CLIENTS, check_reached, keys_for, security_of
from seoro.bridges.session import AsyncSession, SessionError, is_secured, open_session
from seoro.bundle.packing import Bundle, pack
from seoro.client.abilities import check_ability
from seoro.client.runs import RemoteRun
from seoro.client.trying import DryRun, try_bundle
from seoro.client.uploading import with_files
from seoro.embed.arguments import (
    AnyPath,
    optional,
    to_number,
    to_path,
    to_text,
    to_texts,
    to_wait,
    to_whole,
    wrong_type,
)
from seoro.embed.checking import check_options
from seoro.embed.file_settings import with_file_settings
from seoro.embed.options import OptionFields, Options, options_from
from seoro.embed.scenarios import Scenario, check_file
from seoro.errors import InvalidUse
from seoro.film import Film
from seoro.lang.diagnostics import near
from seoro.people import whoami

if TYPE_CHECKING:
    from seoro.client.lab import LabControl
    from seoro.keys.folder import Keys

VARIABLE = "SEORO_EXECUTOR"  # of the environment, with the endpoint


@dataclass(frozen=True)
class ExecutorStatus:
    """How an executor does.

    Args:
        name: Its name.
        info: Its version, and what it has to do.
        clock: How far its clock is from ours; None if it is too old to tell.
    """

    name: str
    info: wire.ExecutorInfo
    clock: Clock | None


def check_priority(priority: int) -> None:
    """Check a priority.

    Raises:
        InvalidUse: There is none such.
    """
    to_whole("priority", priority)
    if not -wire.HIGHEST_PRIORITY <= priority <= wire.HIGHEST_PRIORITY:
        raise InvalidUse(
            f"there is no priority {priority}",
            help=f"priorities go from {-wire.HIGHEST_PRIORITY} to {wire.HIGHEST_PRIORITY}; 0 is that of most runs",
        )


def check_limit(what: str, limit: float | None) -> None:
    """Check a time after which something is done [s], if there is one.

    Raises:
        InvalidUse: It is no finite number above 0.
    """
    if limit is not None and not 0.0 < to_number(what, limit) < math.inf:
        raise InvalidUse(f"`{what}` is a number of seconds above 0, not {limit}", help="leave it out for none")


class Client:
    """A connection to executors; `async with` opens and closes it.

    Args:
        endpoint: Where they are reached; None for that of the environment variable `SEORO_EXECUTOR`, else
            `tcp/127.0.0.1:7470`.
        keys: Folder of keys, for endpoints outside this machine; None for that of the environment variable
            `SEORO_KEYS`, else `~/.config/seoro/keys`.
        patience: For how long an executor that does not answer is asked again [s].

    Opening raises `InvalidUse` when nothing answers there, or the keys are not valid there.
    """

    def __init__(
        self, endpoint: str | None = None, keys: AnyPath | None = None, patience: float = PATIENCE
    ) -> None:
        self.endpoint = optional(to_text, "endpoint", endpoint) or os.environ.get(VARIABLE) or ENDPOINT
        self._patience = to_wait("patience", patience)
        self._folder = optional(to_path, "keys", keys)
        self._keys: Keys | None = None
        self._opened = AsyncExitStack()
        self._session: AsyncSession | None = None

    async def __aenter__(self) -> Self:
        self._keys = keys_for(self.endpoint, CLIENTS, self._folder)
        security = security_of(self.endpoint, self._keys)
        try:
            opening = open_session(connect=self.endpoint, security=security)
            self._session = await self._opened.enter_async_context(opening)
        except SessionError as error:
            check_reached(self.endpoint, security)
            hint = "start an executor with `seoro serve`, or say with `SEORO_EXECUTOR` where one is reached"
            raise InvalidUse(str(error), help=hint) from error
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._session = None
        await self._opened.aclose()

    async def executors(self) -> list[str]:
        """The names of all executors that are there."""
        return [executor.name for executor in await self._all()]

    async def describe(self, executor: str | None = None) -> list[ExecutorStatus]:
        """How an executor does, or all that there are, by their names.

        Raises:
            InvalidUse: There is none.
            BackendError: One is gone.
        """
        return [ExecutorStatus(each.name, *await describe(each)) for each in await self._reached(executor)]

    @property
    def _there(self) -> AsyncSession:
        if self._session is None:
            raise InvalidUse("the client is not open", help="use it in `async with seoro.Client() as client:`")
        return self._session

    async def submit(
        self,
        executor: str,
        scenario: AnyPath | Scenario,
        *,
        stop_if_lost: float | None = None,
        priority: int = 0,
        film: Film | None = None,
        **options: Unpack[OptionFields],
    ) -> RemoteRun:
        """Have a scenario run on an executor.

        It is checked here first, without its Python, and sent with all files that it consists of. What the
        executor finds wrong with it besides, `result` raises.

        Args:
            executor: Name of the executor.
            scenario: Its file, or what `load` returned.
            stop_if_lost: Stop the run when nobody has followed it by `records` or `result` for that many seconds;
                by default, it goes on.
            priority: Of those that wait, runs of higher priority go first; from -100 to 100.
            film: Of its simulator, which the run leaves as `video.mp4`.
            options: As `start`; observers stay here and are called by `records`, files are sent.

        Raises:
            InvalidScenario, InvalidUse: It cannot be run like this; nothing was sent.
            BackendError: The executor refuses it, or is gone.
        """
        check_priority(priority)
        check_limit("stop_if_lost", stop_if_lost)
        if film is not None and not isinstance(film, Film):
            raise wrong_type("film", film, "a seoro.film.Film")
        bundle = _packed(scenario, options_from(options), film)
        return await self.submit_bundle(executor, bundle, stop_if_lost, priority)

    async def submit_bundle(
        self, executor: str, bundle: Bundle, stop_if_lost: float | None = None, priority: int = 0
    ) -> RemoteRun:
        """The same with a bundle that was made before."""
        check_priority(priority)
        check_limit("stop_if_lost", stop_if_lost)
        reached = await self._named(executor)
        await check_ability(reached, bundle, priority)
        submission = wire.Submission(
            run=secrets.token_hex(16),
            manifest=bundle.manifest,
            by=whoami(),
            stop_if_lost=stop_if_lost,
            priority=priority,
        )
        info = await with_files(reached, bundle, lambda _: reached.ask(wire.SUBMIT, submission))
        return RemoteRun(reached, info, stop_if_lost)

    async def dry_run(
        self, executor: str, scenario: AnyPath | Scenario, **options: Unpack[OptionFields]
    ) -> DryRun:
        """Find out whether a scenario could be run on an executor, with which values, and what would be sent.

        It is checked with what is installed and allowed there, its simulator is started and robots are reached; it
        is not run, and nothing stays there.

        Args:
            executor: Name of the executor.
            scenario: As `submit`.
            options: As `submit`.

        Raises:
            InvalidScenario, InvalidUse, BackendError: It cannot be run there.
        """
        return await self.dry_run_bundle(executor, _packed(scenario, options_from(options)))

    async def dry_run_bundle(self, executor: str, bundle: Bundle) -> DryRun:
        """The same with a bundle that was made before."""
        return await try_bundle(await self._named(executor), bundle)

    def lab(self, file: AnyPath | None = None, connect: Sequence[str] = ()) -> LabControl:
        """What looks after a lab: its robots, who has them, and stopping them. It makes connections of its own.

        Args:
            file: The lab file.
            connect: Zenoh endpoints of more nodes, executors or routers. Without any, and without a file, the
                lab is what is alive at the endpoint of the client.

        Raises:
            InvalidUse: There is no such lab file, or something is wrong in it.
        """
        from seoro.client.lab import LabControl  # noqa: PLC0415 - for those who look after labs only
        from seoro.lab.reading import read_lab  # noqa: PLC0415 - the same

        lab = None if file is None else read_lab(to_path("file", file))
        named = (*(() if lab is None else lab.endpoints), *to_texts("connect", connect))
        return LabControl(named or (self.endpoint,), lab, self._folder)

    async def revoke(self, revoked: bytes) -> list[str]:
        """Tell all executors who is revoked; returns their names. For those with the keys of an admin.

        Args:
            revoked: Content of the file `revoked.crl`, which lies beside the key of the lab.

        Raises:
            InvalidUse: There is no executor.
            BackendError: One refuses it, or is gone.
        """
        if not isinstance(revoked, bytes):
            raise wrong_type("revoked", revoked, "bytes")
        reached = await self._reached(None)
        for executor in reached:
            await executor.ask(wire.REVOKE, wire.Revoke(data=revoked))
        return [executor.name for executor in reached]

    async def runs(self, executor: str | None = None, limit: int = 100) -> list[RemoteRun]:
        """The runs of an executor, or of all, the youngest first."""
        to_whole("limit", limit)
        return await self._runs(await self._reached(executor), wire.ListRuns(limit=limit))

    async def run(self, run: str, executor: str | None = None) -> RemoteRun:
        """A run by its id, or by how that begins if no other does.

        Raises:
            InvalidUse: There is none, or there are several.
        """
        to_text("run", run)
        reached = await self._reached(executor)
        if not (1 <= len(run) <= 32 and set(run) <= set("0123456789abcdef")):
            raise InvalidUse(f"'{run}' is no id of a run", help="`seoro ps` lists runs with their ids")
        found = await self._runs(reached, wire.ListRuns(prefix=run, limit=10))
        if len(found) == 1:
            return found[0]
        if found:
            ids = ", ".join(each.id for each in found)
            raise InvalidUse(f"the ids of several runs begin with '{run}'", help=f"there are {ids}")
        known = [each.id[:8] for each in await self._runs(reached, wire.ListRuns())]
        raise InvalidUse(
            f"there is no run '{run}'", help=near(run, known) or "`seoro ps` lists those that there are"
        )

    async def _reached(self, executor: str | None) -> list[Executor]:
        if executor is None:
            found = await self._all()
            if not found:
                raise InvalidUse(
                    f"there is no executor at {self.endpoint}",
                    help=how_to_see_some("seoro serve", is_secured(self.endpoint)),
                )
            return found
        return [await self._named(executor)]

    async def _all(self) -> list[Executor]:
        found = await find_executors(self._there, self._keys, is_secured=is_secured(self.endpoint))
        for executor in found:
            executor.patience = self._patience
        return found

    async def _named(self, name: str) -> Executor:
        to_text("executor", name)
        found = await find_executor(self._there, name, self._keys, is_secured=is_secured(self.endpoint))
        found.patience = self._patience
        return found

    @staticmethod
    async def _runs(executors: Iterable[Executor], request: wire.ListRuns) -> list[RemoteRun]:
        found = [
            RemoteRun(executor, info)
            for executor in executors
            for info in (await executor.ask(wire.LIST_RUNS, request)).runs
        ]
        return sorted(found, key=lambda run: run.info.submitted, reverse=True)[: request.limit]


def _packed(scenario: AnyPath | Scenario, options: Options, film: Film | None = None) -> Bundle:
    check_limit("timeout", options.timeout)
    if not isinstance(scenario, Scenario):
        scenario = check_file(to_path("scenario", scenario), import_python=False)
    settings, of_file = with_file_settings(scenario.without_errors().checked, options, "timeout=SECONDS")
    check_options(settings)
    return pack(scenario, settings, of_file.limit, film=film)
