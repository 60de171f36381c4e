"""Client for executors: runs scenarios over the network, from Python.

    async with seoro.Client() as client:
        run = await client.submit("lab-a", "maze.osc", seed=7)
        async for record in run.records():
            ...
        verdict = await run.result()
        await run.fetch("out")

A run continues at its executor without the client. Any client with its id can follow it from the first record on,
stop it, or download its output files.

May import everything of seoro but `cli`, `doctor`, `lsp` and `executor`.
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

from seoro.bridges.addresses import EXECUTOR
from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import PATIENCE, Executor
from seoro.bridges.executor.clocks import Clock, describe
from seoro.bridges.executor.finding import find_executor, find_executors, start_hint
from seoro.bridges.session import AsyncSession, SessionError, is_secured, open_session
from seoro.bundle.pack import Bundle, pack
from seoro.client.runs import RemoteRun
from seoro.client.sending import DryRun, check_ability, dry_run_bundle, with_files
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
from seoro.embed.file_settings import with_file_settings
from seoro.embed.option_checks import check_options
from seoro.embed.options import OptionFields, Options, options_from
from seoro.embed.scenarios import Scenario, check_file
from seoro.embed.video import VideoOptions
from seoro.embed.whoami import whoami
from seoro.errors import UsageError
from seoro.lang.diagnostics import near
from seoro.security.network.endpoint_keys import CLIENTS, check_reached, keys_for, security_of

if TYPE_CHECKING:
    from seoro.client.lab import LabControl
    from seoro.security.keys.folder import Keys

VARIABLE = "SEORO_EXECUTOR"  # environment variable with the endpoint


@dataclass(frozen=True)
class ExecutorStatus:
    """Status of an executor.

    Args:
        name: Name of the executor.
        info: Its version and load.
        clock: Offset of its clock; None for old versions.
    """

    name: str
    info: wire.ExecutorInfo
    clock: Clock | None


def check_priority(priority: int) -> None:
    """Check a priority.

    Raises:
        UsageError: The priority is out of range.
    """
    to_whole("priority", priority)
    if not -wire.HIGHEST_PRIORITY <= priority <= wire.HIGHEST_PRIORITY:
        raise UsageError(
            f"invalid priority {priority}; expected {-wire.HIGHEST_PRIORITY} to {wire.HIGHEST_PRIORITY}",
            help="the default is 0",
        )


def check_limit(what: str, limit: float | None) -> None:
    """Check an optional time limit [s].

    Raises:
        UsageError: The limit is not a finite number above 0.
    """
    if limit is not None and not 0.0 < to_number(what, limit) < math.inf:
        raise UsageError(
            f"invalid `{what}` {limit}; expected a number of seconds above 0", help="leave it out for no limit"
        )


class Client:
    """A connection to executors; `async with` opens and closes it.

    Args:
        endpoint: Endpoint of executors; None for the environment variable `SEORO_EXECUTOR`, else
            `tcp/127.0.0.1:7470`.
        keys: Folder of keys, for endpoints outside this machine; None for the environment variable `SEORO_KEYS`,
            else `~/.config/seoro/keys`.
        patience: Time for which requests to an unreachable executor are repeated [s].

    Opening raises `UsageError` if nothing answers at the endpoint, or the keys are not valid there.
    """

    def __init__(
        self, endpoint: str | None = None, keys: AnyPath | None = None, patience: float = PATIENCE
    ) -> None:
        self.endpoint = optional(to_text, "endpoint", endpoint) or os.environ.get(VARIABLE) or EXECUTOR
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
            hint = "start an executor with `seoro serve`, or set `SEORO_EXECUTOR` to the endpoint of one"
            raise UsageError(str(error), help=hint) from error
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._session = None
        await self._opened.aclose()

    async def executors(self) -> list[str]:
        """Return the names of all reachable executors."""
        return [executor.name for executor in await self._all()]

    async def describe(self, executor: str | None = None) -> list[ExecutorStatus]:
        """Return the status of one executor, or of all, sorted by name.

        Raises:
            UsageError: The executor is unknown, or none is reachable.
            BackendError: An executor does not answer.
        """
        return [ExecutorStatus(each.name, *await describe(each)) for each in await self._reached(executor)]

    @property
    def _there(self) -> AsyncSession:
        if self._session is None:
            raise UsageError("the client is not open", help="use it in `async with seoro.Client() as client:`")
        return self._session

    async def submit(
        self,
        executor: str,
        scenario: AnyPath | Scenario,
        *,
        stop_if_lost: float | None = None,
        priority: int = 0,
        film: VideoOptions | None = None,
        **options: Unpack[OptionFields],
    ) -> RemoteRun:
        """Submit a scenario to an executor.

        The scenario is checked here first, without its Python, and sent with all its files. `result` raises errors
        that the executor finds.

        Args:
            executor: Name of the executor.
            scenario: Scenario file, or result of `load`.
            stop_if_lost: Time after which the run is stopped if no client follows it by `records` or `result` [s];
                by default, it continues.
            priority: Priority among waiting runs, from -100 to 100; higher ones start first.
            film: Video of its simulator, saved as `video.mp4` among the output files.
            options: Options of `start`; observers stay here and are called by `records`, files are sent.

        Raises:
            InvalidScenario, UsageError: The scenario or an option is invalid; nothing was sent.
            BackendError: The executor rejects it, or does not answer.
        """
        check_priority(priority)
        check_limit("stop_if_lost", stop_if_lost)
        if film is not None and not isinstance(film, VideoOptions):
            raise wrong_type("film", film, "a seoro.embed.video.VideoOptions")
        bundle = bundle_of(scenario, options_from(options), film)
        return await self.submit_bundle(executor, bundle, stop_if_lost, priority)

    async def submit_bundle(
        self,
        executor: str,
        bundle: Bundle,
        stop_if_lost: float | None = None,
        priority: int = 0,
        campaign: wire.CampaignWorker | None = None,
    ) -> RemoteRun:
        """Submit a bundle, or a worker for the runs of a campaign; else like `submit`."""
        check_priority(priority)
        check_limit("stop_if_lost", stop_if_lost)
        reached = await self._named(executor)
        await check_ability(reached, bundle, priority, is_campaign=campaign is not None)
        submission = wire.Submission(
            run=secrets.token_hex(16),
            manifest=bundle.manifest,
            by=whoami(),
            stop_if_lost=stop_if_lost,
            priority=priority,
            campaign=campaign,
        )
        info = await with_files(reached, bundle, lambda _: reached.ask(wire.SUBMIT, submission))
        return RemoteRun(reached, info, stop_if_lost)

    async def dry_run(
        self, executor: str, scenario: AnyPath | Scenario, **options: Unpack[OptionFields]
    ) -> DryRun:
        """Check whether a scenario can run on an executor, with which values, and which files would be sent.

        The executor checks the scenario with its packages and permissions, starts the simulator and connects to
        robots. It does not run the scenario, and keeps nothing of it.

        Args:
            executor: Name of the executor.
            scenario: As for `submit`.
            options: As for `submit`.

        Raises:
            InvalidScenario, UsageError, BackendError: The scenario cannot run there.
        """
        return await self.dry_run_bundle(executor, bundle_of(scenario, options_from(options)))

    async def dry_run_bundle(self, executor: str, bundle: Bundle) -> DryRun:
        """Dry-run a bundle; else like `dry_run`."""
        return await dry_run_bundle(await self._named(executor), bundle)

    def lab(self, file: AnyPath | None = None, connect: Sequence[str] = ()) -> LabControl:
        """Return the control of a lab: states, leases and stops of its robots. It opens its own connections.

        Args:
            file: Lab file.
            connect: Zenoh endpoints of further nodes, executors or routers. Without endpoints and a file, the lab
                consists of all members at the endpoint of the client.

        Raises:
            UsageError: The lab file is missing or invalid.
        """
        from seoro.client.lab import LabControl  # noqa: PLC0415 - only to control labs
        from seoro.lab.reading import read_lab  # noqa: PLC0415 - the same

        lab = None if file is None else read_lab(to_path("file", file))
        named = (*(() if lab is None else lab.endpoints), *to_texts("connect", connect))
        return LabControl(named or (self.endpoint,), lab, self._folder)

    async def revoke(self, revoked: bytes) -> list[str]:
        """Install a list of revoked keys at all executors; returns their names. Requires the role `admin`.

        Args:
            revoked: Content of the file `revoked.crl` in the folder of the lab key.

        Raises:
            UsageError: No executor is reachable.
            BackendError: An executor rejects the list, or does not answer.
        """
        if not isinstance(revoked, bytes):
            raise wrong_type("revoked", revoked, "bytes")
        reached = await self._reached(None)
        for executor in reached:
            await executor.ask(wire.REVOKE, wire.Revoke(data=revoked))
        return [executor.name for executor in reached]

    async def runs(self, executor: str | None = None, limit: int = 100) -> list[RemoteRun]:
        """Return the runs of one executor, or of all, most recent first."""
        to_whole("limit", limit)
        return await self._runs(await self._reached(executor), wire.ListRuns(limit=limit))

    async def run(self, run: str, executor: str | None = None) -> RemoteRun:
        """Return a run by its id, or by a unique beginning of its id.

        Raises:
            UsageError: The id is unknown or ambiguous.
        """
        to_text("run", run)
        reached = await self._reached(executor)
        if not (1 <= len(run) <= 32 and set(run) <= set("0123456789abcdef")):
            raise UsageError(f"invalid id '{run}' of a run", help="`seoro ps` lists runs with their ids")
        found = await self._runs(reached, wire.ListRuns(prefix=run, limit=10))
        if len(found) == 1:
            return found[0]
        if found:
            ids = ", ".join(each.id for each in found)
            raise UsageError(f"ambiguous id '{run}' of a run (runs: {ids})")
        known = [each.id[:8] for each in await self._runs(reached, wire.ListRuns())]
        raise UsageError(f"unknown run '{run}'", help=near(run, known) or "`seoro ps` lists all runs")

    async def _reached(self, executor: str | None) -> list[Executor]:
        if executor is None:
            found = await self._all()
            if not found:
                raise UsageError(
                    f"no executor at {self.endpoint}",
                    help=start_hint("seoro serve", is_secured(self.endpoint)),
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


def bundle_of(scenario: AnyPath | Scenario, options: Options, film: VideoOptions | None = None) -> Bundle:
    """Check a scenario and its options, and pack it with its files, as `Client.submit` does.

    Raises:
        InvalidScenario, UsageError: The scenario or an option is invalid.
    """
    check_limit("timeout", options.timeout)
    if options.replay is not None:
        raise UsageError("executors do not replay runs", help="replay the run in this process: `seoro.replay`")
    if not isinstance(scenario, Scenario):
        scenario = check_file(to_path("scenario", scenario), import_python=False)
    settings, of_file = with_file_settings(scenario.without_errors(), options, "timeout=SECONDS")
    check_options(settings)
    return pack(scenario, settings, of_file.limit, film=film)
