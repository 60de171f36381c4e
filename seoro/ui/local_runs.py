"""Runs in the folders of the site: results with a trace, of past and active runs."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Final

import anyio
import anyio.to_thread

from seoro.campaign.store.folder import CAMPAIGN, KEPT
from seoro.files.inputs import Kind, open_input
from seoro.files.written_files import written_files
from seoro.runtime.execution.outputs import TRACE
from seoro.traces.edges import read_end, read_robots, read_start
from seoro.traces.reader import Record
from seoro.ui.registry import Known, LocalSource, Run, RunRegistry, Status, local_id
from seoro.ui.walking import walk

MOST_RUNS: Final = 10_000
_RECENT: Final = 10.0  # [s] since the last change of a trace that may be active
PERIOD: Final = 1.0  # [s] between looks at the folders
_STATUSES: Final = {
    "passed": Status.PASSED,
    "failed": Status.FAILED,
    "error": Status.ERROR,
    "cancelled": Status.CANCELLED,
}
NO_END: Final = "the trace has no end: the process of the run was killed"


@dataclass(frozen=True)
class _Seen:
    """A trace, as it was read."""

    stamp: tuple[int, int, int]  # inode, size and time of its last change
    run: Run


class LocalRuns:
    """Finds the runs in folders.

    Args:
        roots: The folders, absolute.
    """

    def __init__(self, roots: Sequence[Path]) -> None:
        self._roots = roots
        self._seen: dict[Path, _Seen] = {}

    async def watch(self, registry: RunRegistry) -> None:
        """Keep the runs of a registry up to date, without end."""
        while True:
            before = {each.run.id for each in self._seen.values()}
            found = await anyio.to_thread.run_sync(self.find)
            registry.update(found, before - {each.run.id for each in found})
            await anyio.sleep(PERIOD)

    def find(self) -> list[Known]:
        """Return all runs in the folders."""
        before, self._seen = self._seen, {}
        for path in self._traces():
            try:
                stamp = _stamp(path)
                known = before.get(path)
                if known is None or known.stamp != stamp:
                    known = _Seen(stamp, describe(path, self._roots))
            except OSError:
                continue  # deleted meanwhile, or unreadable
            self._seen[path] = known
        self._mark_killed(before)
        return [Known(each.run, LocalSource(path, path.parent)) for path, each in self._seen.items()]

    def _traces(self) -> Iterator[Path]:
        count = 0
        for folder, folders, files in walk(self._roots):
            if CAMPAIGN in files and KEPT in folders:
                folders.remove(KEPT)  # pages of campaigns list their kept runs
            if TRACE in files:
                count += 1
                yield folder / TRACE
            if count >= MOST_RUNS:
                return

    def _mark_killed(self, before: dict[Path, _Seen]) -> None:
        """Distinguish active runs from killed ones, whose traces have no end either."""
        endless = {path for path, each in self._seen.items() if not each.run.status.is_final}
        held = written_files(endless) if endless else set()
        for path in endless - held:
            found, earlier = self._seen[path], before.get(path)
            is_old = time.time() - found.stamp[2] / 1e9 > _RECENT
            if is_old or (earlier is not None and earlier.stamp == found.stamp):  # another machine may write it
                ended = found.stamp[2] / 1e9
                run = _changed(found.run, status=Status.KILLED, reason=NO_END, ended=ended)
                self._seen[path] = _Seen(found.stamp, run)


def describe(trace: Path, roots: Sequence[Path]) -> Run:
    """Describe the run of a trace on this machine.

    Raises:
        OSError: The trace cannot be read.
    """
    with open_input(trace, Kind.TRACE) as file:
        start, end = read_start(file) or {}, read_end(file)
        robots = read_robots(file, start)
    status = Status.RUNNING if end is None else _STATUSES.get(str(end.get("status")), Status.ERROR)
    started = _wall(start)
    return Run(
        id=local_id(trace),
        place=_shown(trace.parent, roots),
        kind="folder",
        scenario=str(start.get("scenario", "")),
        file=str(start.get("file", "")),
        status=status,
        reason=str((end or {}).get("reason", "")),
        submitted=started,
        started=started,
        ended=_wall(end or {}),
        robots=robots,
        folder=str(trace.parent),
    )


def _shown(folder: Path, roots: Sequence[Path]) -> str:
    """Return the name of a folder relative to the folder of the site above it."""
    for root in roots:
        if folder.is_relative_to(root):
            inside = folder.relative_to(root)
            return str(Path(root.name, inside)) if len(roots) > 1 else str(inside) if inside.parts else root.name
    return str(folder)


def _changed(run: Run, **changes: object) -> Run:
    return Run(**{**vars(run), **changes})


def _wall(record: Record) -> float | None:
    try:
        return datetime.fromisoformat(str(record.get("wall"))).timestamp()
    except (ValueError, OverflowError):
        return None


def _stamp(path: Path) -> tuple[int, int, int]:
    found = path.stat()
    return found.st_ino, found.st_size, found.st_mtime_ns
