"""Campaigns in the folders of the site, each read once for all its viewers."""

from __future__ import annotations

import os
import time
from collections import Counter, OrderedDict, deque
from collections.abc import AsyncGenerator, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import anyio
import anyio.to_thread

from seoro.campaign.report.page import page, without_controls
from seoro.campaign.runs import End, Row
from seoro.campaign.store.folder import CAMPAIGN, KEPT, LOCK, RUNS, TRACE, CampaignFile, read_campaign, shards_of
from seoro.campaign.store.index import end_in
from seoro.campaign.store.lines import read_blocks
from seoro.errors import UsageError
from seoro.files.written_files import written_files
from seoro.ui.answers import RequestError
from seoro.ui.campaign_json import described, snapshot_of
from seoro.ui.campaign_reader import CampaignReader
from seoro.ui.local_runs import describe
from seoro.ui.registry import Known, LocalSource, RunRegistry, local_id
from seoro.ui.walking import walk

RUNNING: Final = "running"
PERIOD: Final = 1.0  # [s] between two snapshots
READ_TIME: Final = 0.5  # [s] of a thread, between two snapshots while much is unread
PACE_TIME: Final = 30.0  # [s] over which runs per second are counted
MOST_CAMPAIGNS: Final = 1000  # in the list
MOST_READERS: Final = 20  # campaigns whose rows stay summarized
RECENT: Final = 10.0  # [s] since the last row of a campaign that another user may carry out


class CampaignFeed:
    """A campaign for its viewers.

    Args:
        folder: Its folder.
        roots: Folders of the site.
        runs: Runs of the site, which its kept runs become.

    Raises:
        UsageError: The folder is not that of a campaign.
    """

    def __init__(self, folder: Path, roots: Sequence[Path], runs: RunRegistry) -> None:
        self._reader = CampaignReader(folder)
        self._roots = roots
        self._runs = runs
        self._lock = anyio.Lock()
        self._blocks: Iterator[int] | None = None
        self._is_behind = True  # rows are unread
        self._kept: dict[int, Known | None] = {}
        self._new_kept: list[Known] = []
        self._pace: deque[tuple[float, int]] = deque()
        self._at = -PERIOD
        self._data: Mapping[str, Any] = {}

    async def snapshots(self) -> AsyncGenerator[Mapping[str, Any], None]:
        """Yield the results, and then each change; a slow viewer misses some.

        Raises:
            UsageError, OSError: A file of the campaign is invalid, or cannot be read.
        """
        last: Mapping[str, Any] = {}
        while True:
            present = await self._present()
            if present != last:
                last = present
                yield present
            if not present["isReading"]:
                await anyio.sleep(PERIOD)

    async def _present(self) -> Mapping[str, Any]:
        async with self._lock:
            if self._is_behind or time.monotonic() - self._at >= PERIOD:
                self._data = await anyio.to_thread.run_sync(self._refresh)
                self._at = time.monotonic()
                found, self._new_kept = self._new_kept, []
                self._runs.add_unlisted(found)
        return self._data

    def _refresh(self) -> Mapping[str, Any]:
        was_behind, before = self._is_behind, self._reader.summary.runs
        self._read(READ_TIME)
        campaign, done = self._reader.campaign, self._reader.summary.runs
        is_growing = not was_behind and done > before  # also on another machine
        is_held = is_growing or bool(written_files({self._reader.folder / LOCK}))
        is_over = bool(self._reader.stop) or done == campaign.runs
        status = status_of(self._reader.folder, campaign, is_held=is_held, is_over=is_over)
        pace = self._count_pace(done) if status == RUNNING and not self._is_behind else None
        left = (campaign.runs - done) / pace if pace and campaign.runs is not None else None
        return {
            **snapshot_of(self._reader, self._kept_id),
            "isReading": self._is_behind,
            "status": status,
            "active": status == RUNNING,
            "perSecond": pace,
            "timeLeft": left,
            "problem": "",
        }

    def _read(self, seconds: float) -> None:
        """Read rows for a time, which the event loop of the site shares with this thread."""
        until = time.monotonic() + seconds
        blocks, self._blocks = self._blocks or self._reader.read_new(), None  # None after an error, too
        for _ in blocks:
            if time.monotonic() > until:
                self._blocks = blocks
                break
        self._is_behind = self._blocks is not None

    def _count_pace(self, done: int) -> float | None:
        """Return the runs per second of the last time; None if they are not known yet."""
        now = time.monotonic()
        while self._pace and now - self._pace[0][0] > PACE_TIME:
            self._pace.popleft()
        self._pace.append((now, done))
        began, before = self._pace[0]
        return (done - before) / (now - began) if done > before else None

    def _kept_id(self, row: Row) -> str | None:
        """Return the id of a kept run, and note the run for the site."""
        if row.run not in self._kept:
            known = self._kept[row.run] = kept_run(self._reader.folder, row.folder, self._roots)
            if known is not None:
                self._new_kept.append(known)
        found = self._kept[row.run]
        return None if found is None else found.run.id

    async def report(self) -> bytes:
        """Return `report.html` of the runs so far.

        Raises:
            UsageError, OSError: A file of the campaign is invalid, or cannot be read.
        """
        async with self._lock:
            return await anyio.to_thread.run_sync(self._write_report)

    def _write_report(self) -> bytes:
        self._read(float("inf"))
        text = "".join(page(self._reader.summary, self._reader.campaign, self._reader.folder))
        return without_controls(text).encode()


def kept_run(folder: Path, kept: str, roots: Sequence[Path]) -> Known | None:
    """Return a kept run of a campaign; None without a trace inside the folder of the campaign.

    Args:
        folder: Folder of the campaign.
        kept: Folder of the run, as its row has it.
        roots: Folders of the site.
    """
    trace = folder / kept / TRACE
    try:
        if not kept or not trace.resolve(strict=True).is_relative_to(folder.resolve() / KEPT):
            return None
        return Known(describe(trace, roots), LocalSource(trace, trace.parent))
    except (OSError, ValueError):
        return None


def status_of(folder: Path, campaign: CampaignFile, *, is_held: bool, is_over: bool) -> str:
    """Return `running`, `complete`, `stopped` for a campaign that may be continued, or `ended` for one of the two.

    Args:
        folder: Folder of the campaign.
        campaign: Content of its `campaign.json`.
        is_held: Whether a process is known to carry it out.
        is_over: Whether all its runs have ended, or a rule has ended it.
    """
    if is_held:
        return RUNNING
    if is_over:
        return "complete"
    with suppress(OSError):  # processes of other users are hidden
        if (folder / LOCK).stat().st_uid != os.getuid() and time.time() - changed_at(folder) < RECENT:
            return RUNNING
    return "ended" if campaign.runs is None else "stopped"


def changed_at(folder: Path) -> float:
    """Return the time of the last change of a campaign [s since 1970]; 0 if it was deleted."""
    times = []
    for path in (folder / CAMPAIGN, *shards_of(folder)):
        with suppress(OSError):
            times.append(path.stat().st_mtime)
    return max(times, default=0.0)


@dataclass
class _Counts:
    """Ends of the rows of a campaign, as far as they were read."""

    ends: Counter[str] = field(default_factory=Counter)
    read: dict[Path, int] = field(default_factory=dict)  # position behind the last line [bytes]


class CampaignFeeds:
    """All campaigns in folders.

    Args:
        roots: The folders.
        runs: Runs of the site.
    """

    def __init__(self, roots: Sequence[Path], runs: RunRegistry) -> None:
        self._roots = roots
        self._runs = runs
        self._feeds: OrderedDict[str, CampaignFeed] = OrderedDict()
        self._folders: dict[str, Path] = {}
        self._counts: dict[Path, _Counts] = {}
        self._lock = anyio.Lock()

    async def feed(self, campaign: str) -> CampaignFeed:
        """Return a campaign by its id.

        Raises:
            RequestError: The id is unknown.
            UsageError: Its folder is invalid.
        """
        async with self._lock:
            if campaign not in self._folders:
                await anyio.to_thread.run_sync(self._find)
            folder = self._folders.get(campaign)
            if folder is None:
                raise RequestError(
                    404, "unknown campaign", "it was deleted, or its folder does not belong to this site"
                )
            if campaign not in self._feeds:
                self._feeds[campaign] = await anyio.to_thread.run_sync(
                    CampaignFeed, folder, self._roots, self._runs
                )
            self._feeds.move_to_end(campaign)
            while len(self._feeds) > MOST_READERS:
                self._feeds.popitem(last=False)
            return self._feeds[campaign]

    async def listed(self) -> list[Mapping[str, Any]]:
        """Return all campaigns, the one that changed last first."""
        async with self._lock:
            return await anyio.to_thread.run_sync(self._list)

    def _find(self) -> None:
        found: dict[str, Path] = {}
        for folder, folders, files in walk(self._roots):
            if CAMPAIGN in files and RUNS in folders:
                folders.clear()  # campaigns around its runs belong to its report
                found[campaign_id(folder)] = folder
                if len(found) >= MOST_CAMPAIGNS:
                    break
        self._folders = found
        self._counts = {folder: self._counts.get(folder, _Counts()) for folder in found.values()}

    def _list(self) -> list[Mapping[str, Any]]:
        self._find()
        held = written_files({folder / LOCK for folder in self._folders.values()})
        found = [
            self._entry(name, folder, is_held=folder / LOCK in held) for name, folder in self._folders.items()
        ]
        return sorted(found, key=lambda each: -(each["lastStart"] or 0.0))

    def _entry(self, name: str, folder: Path, *, is_held: bool) -> Mapping[str, Any]:
        found: dict[str, Any] = {
            "id": name,
            "folder": shown_folder(folder, self._roots),
            "title": folder.name,
            "runs": None,
            "done": 0,
            "counts": {},
            "status": "ended",
            "active": False,
            "firstStart": None,
            "lastStart": changed_at(folder) or None,
            "problem": "",
        }
        try:
            campaign, begun = read_campaign(folder), (folder / CAMPAIGN).stat().st_mtime
            ends = self._ends(folder)
        except (UsageError, OSError) as error:
            return {**found, "problem": str(error)}
        done = ends.total() - ends[End.IMPOSSIBLE.value]
        status = status_of(folder, campaign, is_held=is_held, is_over=done == campaign.runs)
        return {
            **found,
            **described(campaign),
            "done": done,
            "counts": {end.value: ends[end.value] for end in End if end is not End.IMPOSSIBLE},
            "status": status,
            "active": status == RUNNING,
            "firstStart": begun,
        }

    def _ends(self, folder: Path) -> Counter[str]:
        """Count the ends of runs; rows that were counted before are not read again."""
        counts = self._counts[folder]
        if any(path.stat().st_size < start for path, start in counts.read.items() if path.exists()):
            counts = self._counts[folder] = _Counts()
        for path in shards_of(folder):
            for lines in read_blocks(path, counts.read.get(path, 0)):
                counts.ends.update(end_in(line, str(path))[1] for line in lines)
                counts.read[path] = counts.read.get(path, 0) + sum(map(len, lines))
        return counts.ends


def campaign_id(folder: Path) -> str:
    """Return the id of a campaign, which hides its path."""
    return f"c{local_id(folder)[1:]}"


def shown_folder(folder: Path, roots: Sequence[Path]) -> str:
    """Return the path of a folder from the folder of the site above it."""
    for root in roots:
        if folder.is_relative_to(root):
            return str(Path(root.name, folder.relative_to(root)))
    return folder.name
