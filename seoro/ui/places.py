"""Places of runs: executors of an endpoint, the executor of the site, and folders."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from seoro.client import Client
from seoro.errors import BackendUnreachable
from seoro.ui.executors import Executors

_NO_CLIENT = "no executor is reachable"


class Places:
    """Places of runs.

    Args:
        folders: Folders of the site.
        executors: Executors by endpoint; the first with a client is preferred.
    """

    def __init__(self, folders: Sequence[Path], executors: Sequence[Executors]) -> None:
        self._folders = folders
        self._executors = list(executors)

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
    def has_client(self) -> bool:
        """Whether an endpoint is reachable."""
        return any(each.client is not None for each in self._executors)

    @property
    def data(self) -> list[dict[str, Any]]:
        """JSON data of the places."""
        found = []
        for each in self._executors:
            found += [{"name": each.shown(name), "kind": "executor", "problem": ""} for name in each.names]
            if not each.names and each.problem:
                found.append({"name": each.endpoint or "executors", "kind": "executor", "problem": each.problem})
        for folder in self._folders:
            problem = "" if folder.is_dir() else "the folder was deleted"
            found.append({"name": str(folder), "kind": "folder", "problem": problem})
        return found
