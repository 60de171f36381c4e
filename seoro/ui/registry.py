"""Runs that the pages list: those in folders of this machine, and those of executors."""

from __future__ import annotations

import hashlib
from collections.abc import AsyncIterator, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

import anyio

from seoro.ui.answers import RequestError

if TYPE_CHECKING:
    from seoro.client.runs import RemoteRun

_PERIOD: Final = 0.2  # [s] between changes for a viewer
_ID_DIGITS: Final = 24


class Status(StrEnum):
    """Status of a run, as the pages show it."""

    WAITING = "waiting"
    RUNNING = "running"
    PASSED = "passed"
    FAILED = "failed"
    ERROR = "error"
    CANCELLED = "cancelled"
    KILLED = "killed"

    @property
    def is_final(self) -> bool:
        """Whether the run is over."""
        return self not in (Status.WAITING, Status.RUNNING)


@dataclass(frozen=True)
class Run:
    """A run in the list. Times are seconds since the epoch.

    Args:
        id: Opaque id.
        place: Name of its executor, or its folder.
        kind: Kind of the place.
        scenario: Name of the scenario; empty if unknown.
        file: Scenario file, for people.
        status: Status.
        reason: Reason of its end, or of its status.
        submitted: Time of its submission; None if unknown.
        started: Time of its start.
        ended: Time of its end.
        by: User who started it.
        robots: Names of its robots, if known.
        waits: Busy robots, and their holders.
        position: Position in the queue, from 1 on.
        may_stop: Whether these pages can stop it.
        folder: Folder of its results on this machine; empty elsewhere.
    """

    id: str
    place: str
    kind: Literal["executor", "folder"]
    scenario: str
    file: str
    status: Status
    reason: str = ""
    submitted: float | None = None
    started: float | None = None
    ended: float | None = None
    by: str = ""
    robots: tuple[str, ...] = ()
    waits: str = ""
    position: int | None = None
    may_stop: bool = False
    folder: str = ""

    @property
    def data(self) -> dict[str, Any]:
        """JSON data of the run."""
        found = dict(vars(self))
        found["mayStop"] = found.pop("may_stop")
        return found


@dataclass(frozen=True)
class LocalSource:
    """A run in a folder of this machine.

    Args:
        trace: Its trace.
        folder: Its results; None for a trace alone.
    """

    trace: Path
    folder: Path | None


Source: TypeAlias = "LocalSource | RemoteRun"


@dataclass(frozen=True)
class Known:
    """A run with the source of its trace."""

    run: Run
    source: Source


@dataclass(frozen=True)
class Changes:
    """Changes of the list.

    Args:
        changed: New and changed runs.
        removed: Ids of removed runs.
        is_first: Whether `changed` are all runs.
    """

    changed: tuple[Run, ...]
    removed: tuple[str, ...]
    is_first: bool

    @property
    def data(self) -> dict[str, Any]:
        """JSON data of the changes."""
        runs = [run.data for run in self.changed]
        return {"runs": runs} if self.is_first else {"changed": runs, "removed": self.removed}


def local_id(trace: Path) -> str:
    """Return the id of a run in a folder of this machine, which hides its path."""
    return f"f{hashlib.sha256(bytes(trace.absolute())).hexdigest()[:_ID_DIGITS]}"


def remote_id(run: str) -> str:
    """Return the id of a run on an executor."""
    return f"x{run}"


class RunRegistry:
    """All known runs by id."""

    def __init__(self) -> None:
        self._known: dict[str, Known] = {}
        self._unlisted: dict[str, Known] = {}
        self._changed = anyio.Event()

    def get(self, run: str) -> Known:
        """Return a run by its id.

        Raises:
            RequestError: The id is unknown.
        """
        found = self._known.get(run) or self._unlisted.get(run)
        if found is None:
            raise RequestError(404, "unknown run", "it was deleted, or its folder does not belong to this site")
        return found

    def all(self) -> list[Known]:
        """Return all runs, in no order."""
        return list(self._known.values())

    def update(self, found: Iterable[Known], removed: Iterable[str] = ()) -> None:
        """Add or replace runs, and remove others.

        Args:
            found: Runs.
            removed: Ids; unknown ones are ignored.
        """
        before = self._known
        after = {**before, **{each.run.id: each for each in found}}
        for run in removed:
            after.pop(run, None)
        self._known = after
        if _runs(before) != _runs(after):
            self._changed.set()
            self._changed = anyio.Event()

    def add_unlisted(self, found: Iterable[Known]) -> None:
        """Add runs that the list does not have, such as those of campaigns."""
        self._unlisted.update({each.run.id: each for each in found})

    async def wait(self) -> None:
        """Wait for the next change."""
        await self._changed.wait()

    async def changes(self) -> AsyncIterator[Changes]:
        """Yield all runs, and then their changes; a slow receiver gets fewer, larger ones."""
        seen: Mapping[str, Run] = {}
        is_first = True
        while True:
            changed_later, now = self._changed, _runs(self._known)
            changed = tuple(run for name, run in now.items() if seen.get(name) != run)
            removed = tuple(name for name in seen if name not in now)
            if is_first or changed or removed:
                yield Changes(changed, removed, is_first)
            seen, is_first = now, False
            await changed_later.wait()
            await anyio.sleep(_PERIOD)


def _runs(known: Mapping[str, Known]) -> dict[str, Run]:
    return {name: each.run for name, each in known.items()}
