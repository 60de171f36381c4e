"""Runs of the scenario files of some folders, for clients that name files and parameters only."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Final

import anyio
import anyio.to_thread
from anyio.abc import TaskGroup

from seoro.bridges.ros2.runs.contract import RunState
from seoro.client import Client, bundle_of
from seoro.client.runs import RemoteRun
from seoro.concurrency.condition import Condition
from seoro.embed.arguments import to_overrides
from seoro.embed.options import Options
from seoro.errors import BackendError, UsageError
from seoro.files.inputs import resolved
from seoro.files.plain_yaml import read_yaml
from seoro.lang.diagnostics import near

KEPT: Final = 20  # states of ended runs
LISTED: Final = 1000  # scenario files
CLEANUP: Final = 60.0  # [s] maximum wait for the end of stopped runs
SUFFIX: Final = ".osc"

log = logging.getLogger(__name__)


@dataclass
class _Started:
    """A run, and what its executor does not state."""

    run: RemoteRun
    file: str
    is_stopping: bool = False
    problem: str = ""  # reason why its state is unknown

    @property
    def state(self) -> RunState:
        info = self.run.info
        return RunState(
            run=info.run,
            file=self.file,
            state=info.state,
            reason=self.problem or info.reason or info.waits,
            announcement=info.announcement,
            is_stopping=self.is_stopping,
            is_lost=bool(self.problem),
        )


class ServedRuns:
    """Runs on an executor; see `seoro.bridges.ros2.runs.contract.Runs`.

    Args:
        client: Client of the executor.
        executor: Name of the executor.
        folders: Folders of scenario files; others are not started.
        options: Options of the runs, apart from parameters.
        tasks: Task group that follows the runs.
        stop_if_lost: See `Client.submit`.
        priority: See `Client.submit`.
    """

    def __init__(
        self,
        client: Client,
        executor: str,
        folders: Sequence[Path],
        options: Options,
        tasks: TaskGroup,
        *,
        stop_if_lost: float | None = None,
        priority: int = 0,
    ) -> None:
        self.changed = Condition()
        self._client = client
        self._executor = executor
        self._folders = [resolved(folder) for folder in folders]
        self._options = options
        self._tasks = tasks
        self._stop_if_lost = stop_if_lost
        self._priority = priority
        self._started: list[_Started] = []

    def states(self) -> Sequence[RunState]:
        """Return the states of active runs and of the last ended ones, in the order of their starts."""
        return [each.state for each in self._started]

    def files(self) -> Sequence[Path]:
        """Return the scenario files in the folders, without those in folders below, at most 1000."""
        found = [path for folder in self._folders for path in sorted(folder.glob(f"*{SUFFIX}")) if path.is_file()]
        return found[:LISTED]

    async def start(self, name: str, parameters: str = "") -> RunState:
        """Start a run, or queue it; see `Runs.start`.

        Raises:
            UsageError: The file is not in a folder, or the parameters are invalid.
            InvalidScenario: The scenario is invalid.
            BackendError: The executor refuses the run, or does not answer.
        """
        values = read_values(parameters)
        path = await anyio.to_thread.run_sync(self.find, name)
        options = replace(self._options, overrides={**self._options.overrides, **values})
        bundle = await anyio.to_thread.run_sync(bundle_of, path, options)
        run = await self._client.submit_bundle(self._executor, bundle, self._stop_if_lost, self._priority)
        started = _Started(run, path.name)
        self._started.append(started)
        self._forget()
        self.changed.notify_all()
        self._tasks.start_soon(self._follow, started)
        return started.state

    def find(self, name: str) -> Path:
        """Return the path of a scenario file.

        Raises:
            UsageError: It is not in a folder.
        """
        if not name:
            known = ", ".join(path.name for path in self.files()) or "none"
            raise UsageError("the request names no scenario file", help=f"scenario files: {known}")
        if "\0" not in name:
            for folder in self._folders:
                for path in (resolved(folder / name), resolved(folder / f"{name}{SUFFIX}")):
                    if path.is_relative_to(folder) and path.suffix == SUFFIX and path.is_file():
                        return path
        served = ", ".join(map(str, self._folders))
        names = [path.name for path in self.files()]
        raise UsageError(
            f"no scenario file {name!r} in the served folders ({served})",
            help=near(name, names) or f"scenario files: {', '.join(names) or 'none'}",
        )

    def _forget(self) -> None:
        """Forget the runs that ended first."""
        over = [each for each in self._started if each.state.is_over]
        for each in over[: max(0, len(over) - KEPT)]:
            self._started.remove(each)

    async def _follow(self, started: _Started) -> None:
        shown = started.state
        try:
            async for _ in started.run.lines():
                if started.state != shown:
                    shown = started.state
                    self.changed.notify_all()
        except BackendError as error:
            started.problem = str(error)
        log.info("%s: run %s %s", started.file, shown.run, started.state.text)
        self.changed.notify_all()

    async def stop(self, reason: str) -> Sequence[RunState]:
        """Stop all active runs, and wait until they have cleaned up, at most a minute; returns their last states.

        Raises:
            BackendError: The executor does not answer.
        """
        active = [each for each in self._started if not each.state.is_over]
        for each in active:
            each.is_stopping = True
        self.changed.notify_all()
        for each in active:
            await each.run.stop(reason)
        with anyio.move_on_after(CLEANUP):
            await self.changed.wait_for(lambda: all(each.state.is_over for each in active))
        return [each.state for each in active]


def read_values(text: str) -> Mapping[str, str]:
    """Read values of parameters.

    Args:
        text: YAML mapping of the paths of parameters to numbers, lists, or expressions of the language.

    Raises:
        UsageError: The text is another value, or invalid YAML.
    """
    if not text.strip():
        return MappingProxyType({})
    try:
        value = read_yaml(text)
    except ValueError as error:
        raise UsageError(
            f"invalid `parameters`: {error}", help="write a mapping such as {speed: 0.3mps}"
        ) from None
    return to_overrides("parameters", value)
