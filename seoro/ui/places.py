"""Places of runs: executors of an endpoint, the executor of the site, and folders."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import anyio

from seoro.client import Client
from seoro.errors import BackendUnreachable, UsageError
from seoro.ui.executors import Executors

_LOST = "the executor ended, or is unreachable"
_NO_CLIENT = "no executor is reachable"


class Places:
    """Places of runs.

    Args:
        folders: Folders of the site.
    """

    def __init__(self, folders: Sequence[Path]) -> None:
        self._folders = folders
        self._executors: list[Executors] = []
        self._changed = anyio.Event()

    def add(self, executors: Executors) -> None:
        """Add the executors at an endpoint; the first with a client is preferred."""
        executors.on_change = self._notify
        self._executors.append(executors)

    def remove(self, executors: Executors) -> None:
        """Remove the executors at an endpoint."""
        self._executors.remove(executors)

    def _notify(self) -> None:
        self._changed.set()
        self._changed = anyio.Event()

    async def wait_for(self, shown: str) -> None:
        """Wait until an executor is reachable.

        Args:
            shown: Name of the executor for people.
        """
        while not any(each.shown(name) == shown for each in self._executors for name in each.names):
            await self._changed.wait()

    def find(self, shown: str) -> tuple[Client, str]:
        """Return the client and the name of an executor.

        Args:
            shown: Name of the executor for people.

        Raises:
            UsageError: The executor is unknown.
        """
        for each in self._executors:
            for name in each.names:
                if each.client is not None and each.shown(name) == shown:
                    return each.client, name
        known = ", ".join(each.shown(name) for each in self._executors for name in each.names)
        raise UsageError(
            f"unknown executor '{shown}'", help=f"executors: {known}" if known else "no executor is reachable"
        )

    def client(self) -> Client:
        """Return the client of the preferred endpoint.

        Raises:
            BackendUnreachable: No endpoint is reachable.
        """
        for each in sorted(self._executors, key=lambda found: not found.names):
            if each.client is not None:
                return each.client
        reason = next((each.problem for each in self._executors if each.problem), "")
        raise BackendUnreachable(
            f"{_NO_CLIENT}: {reason}" if reason else _NO_CLIENT,
            "start an executor with `seoro serve`, and name its endpoint with `--connect`",
        )

    @property
    def endpoints(self) -> list[str]:
        """Endpoints of executors that were named, or are reachable."""
        found = [each.client.endpoint if each.client is not None else each.endpoint for each in self._executors]
        return [endpoint for endpoint in found if endpoint is not None]

    @property
    def has_client(self) -> bool:
        """Whether an endpoint is reachable."""
        return any(each.client is not None for each in self._executors)

    @property
    def has_executor(self) -> bool:
        """Whether an executor is reachable."""
        return any(each.names for each in self._executors)

    @property
    def data(self) -> list[dict[str, Any]]:
        """JSON data of the places."""
        found = []
        for each in self._executors:
            problems = {name: each.silent.get(name, "") for name in each.names} | dict.fromkeys(each.lost, _LOST)
            found += [
                {"name": each.shown(name), "kind": "executor", "problem": problem}
                for name, problem in sorted(problems.items())
            ]
            if not each.names and each.problem and each.is_chosen:
                found.append({"name": each.endpoint or "executors", "kind": "executor", "problem": each.problem})
        for folder in self._folders:
            problem = "" if folder.is_dir() else "the folder was deleted"
            found.append({"name": str(folder), "kind": "folder", "problem": problem})
        return found
