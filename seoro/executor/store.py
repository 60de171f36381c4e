"""What an executor keeps: runs in SQLite, and their files in a folder each.

    executor.lock      held while an executor uses the folder
    runs.sqlite        one row a run
    blobs/<hash>       contents of bundles
    runs/<run>/        files/ (the bundle), output/ (what the run left), trace.jsonl, home/ (while it runs)

All of SQLite is done by one thread, in the order in which it is asked for. What is acknowledged is on the disk
before: a run with its bundle when it is taken in; its beginning; its end with its trace and what it has left.
"""

from __future__ import annotations

import asyncio
import fcntl
import os
import shutil
import sqlite3
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeVar

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.messages import RunInfo, State
from seoro.bridges.wire import encode
from seoro.durable import sync_file, sync_folder, sync_tree
from seoro.errors import InvalidUse

T = TypeVar("T")

CACHE: Final = 256  # [KiB] of the database in memory, which would else grow with the runs for a long time
SCHEMA: Final = 3
_TABLES: Final = """
CREATE TABLE runs (
    number INTEGER PRIMARY KEY,          -- in the order of submission
    run TEXT NOT NULL UNIQUE,
    file TEXT NOT NULL,
    by TEXT NOT NULL,
    state TEXT NOT NULL,
    submitted REAL NOT NULL,
    started REAL,
    ended REAL,
    reason TEXT NOT NULL DEFAULT '',
    announcement TEXT NOT NULL DEFAULT '',
    submission BLOB NOT NULL,            -- the message
    end BLOB NOT NULL DEFAULT x'',       -- `seoro.embed.ends`
    priority INTEGER NOT NULL DEFAULT 0,
    trace TEXT NOT NULL DEFAULT ''       -- SHA-256 of the whole trace; empty if that is unknown
) STRICT;
CREATE INDEX runs_by_state ON runs (state);
"""
_RENEWALS: Final = {  # from that schema on
    1: "ALTER TABLE runs ADD COLUMN priority INTEGER NOT NULL DEFAULT 0;",
    2: "ALTER TABLE runs ADD COLUMN trace TEXT NOT NULL DEFAULT '';",
}
_FIELDS: Final = "run, file, by, state, submitted, started, ended, reason, announcement, priority, trace"
LOST: Final = "the executor died while the scenario ran"


@dataclass(frozen=True)
class RunFolder:
    """Where the files of a run lie."""

    path: Path

    @property
    def files(self) -> Path:
        """The bundle."""
        return self.path / "files"

    @property
    def output(self) -> Path:
        """What the run has left."""
        return self.path / "output"

    @property
    def trace(self) -> Path:
        """Its trace."""
        return self.path / "trace.jsonl"

    @property
    def home(self) -> Path:
        """The home folder of its programs, while it runs."""
        return self.path / "home"

    @property
    def log(self) -> Path:
        """What its process has printed, which it leaves, too."""
        return self.output / "log.txt"

    def sync(self) -> None:
        """Force its trace, and what the run has left, to the disk; blocks.

        Raises:
            OSError: That cannot be done.
        """
        if self.output.exists():
            sync_tree(self.output)
        if self.trace.exists():
            sync_file(self.trace)
        sync_folder(self.path)


@dataclass(frozen=True)
class Finished:
    """How a run ended: what became of it, why, `seoro.embed.ends`, when [s since 1970], SHA-256 of its trace."""

    state: State
    reason: str
    end: bytes
    ended: float
    trace: str = ""


class Store:
    """Runs, kept. Made by `open_store`.

    Args:
        folder: For everything.
        database: Of the runs.
    """

    def __init__(self, folder: Path, database: sqlite3.Connection, thread: ThreadPoolExecutor) -> None:
        self._folder = folder
        self._database = database
        self._thread = thread

    @property
    def root(self) -> Path:
        """The folder of everything."""
        return self._folder

    @property
    def blobs(self) -> Path:
        """The folder of the blobs."""
        return self._folder / "blobs"

    def folder(self, run: str) -> RunFolder:
        """Where the files of a run lie."""
        return RunFolder(self._folder / "runs" / run)

    async def _do(self, work: Callable[[sqlite3.Connection], T]) -> T:
        def carry_out() -> T:
            with self._database:  # a transaction
                return work(self._database)

        return await asyncio.get_running_loop().run_in_executor(self._thread, carry_out)

    async def add(self, submission: wire.Submission) -> RunInfo:
        """Keep a new run, queued; one of that id that there is already stays as it is."""
        values = (
            submission.run, submission.manifest.shown, submission.by, State.QUEUED.value, time.time(),
            encode(submission), submission.priority,
        )  # fmt: skip
        fields = "run, file, by, state, submitted, submission, priority"
        command = f"INSERT OR IGNORE INTO runs ({fields}) VALUES (?,?,?,?,?,?,?)"  # noqa: S608 - names of ours
        await self._do(lambda database: database.execute(command, values))
        return await self.info(submission.run)

    async def submission(self, run: str) -> wire.Submission:
        """What a run was submitted with."""
        [row] = await self._rows("SELECT submission FROM runs WHERE run = ?", run)
        return wire.SUBMIT.read(row[0])

    async def info(self, run: str) -> RunInfo:
        """What is known of a run.

        Raises:
            KeyError: There is none of that id.
        """
        rows = await self._rows(f"SELECT {_FIELDS} FROM runs WHERE run = ?", run)  # noqa: S608 - names of ours
        if not rows:
            raise KeyError(run)
        return _info(rows[0])

    async def end(self, run: str) -> bytes:
        """What a run ended with; empty if that is not known."""
        [row] = await self._rows("SELECT end FROM runs WHERE run = ?", run)
        end: bytes = row[0]
        return end

    async def youngest(self, limit: int, prefix: str = "") -> tuple[RunInfo, ...]:
        """The runs that were submitted last, whose ids begin so."""
        command = f"SELECT {_FIELDS} FROM runs WHERE run GLOB ? ORDER BY number DESC LIMIT ?"  # noqa: S608 - as above
        return tuple(map(_info, await self._rows(command, f"{prefix}*", limit)))

    async def queued(self) -> tuple[str, ...]:
        """The ids of runs that wait, the oldest first."""
        rows = await self._rows("SELECT run FROM runs WHERE state = ? ORDER BY number", State.QUEUED.value)
        return tuple(row[0] for row in rows)

    async def running(self) -> tuple[RunInfo, ...]:
        """Runs that go on, or did when an executor before this one died."""
        command = f"SELECT {_FIELDS} FROM runs WHERE state = ? ORDER BY number"  # noqa: S608 - names of ours
        return tuple(map(_info, await self._rows(command, State.RUNNING.value)))

    async def over(self, before: float) -> tuple[str, ...]:
        """The ids of runs that ended before a time."""
        rows = await self._rows("SELECT run FROM runs WHERE ended < ?", before)
        return tuple(row[0] for row in rows)

    async def _rows(self, command: str, *values: object) -> list[tuple[Any, ...]]:
        return await self._do(lambda database: database.execute(command, values).fetchall())

    async def start(self, run: str) -> None:
        """A run has its process."""
        await self._set(run, state=State.RUNNING.value, started=time.time())

    async def wait(self, run: str) -> None:
        """A run waits for others before it begins: if the executor dies, the next one has it to begin."""
        await self._set(run, state=State.QUEUED.value, started=None)

    async def announce(self, run: str, announcement: str) -> None:
        """It is known what a run runs with."""
        await self._set(run, announcement=announcement)

    async def finish(self, run: str, how: Finished) -> None:
        """A run is over."""
        values = {"ended": how.ended, "reason": how.reason, "end": how.end, "trace": how.trace}
        await self._set(run, state=how.state.value, **values)

    async def _set(self, run: str, **values: object) -> None:
        assignments = ", ".join(f"{name} = ?" for name in values)
        command = f"UPDATE runs SET {assignments} WHERE run = ?"  # noqa: S608 - names of ours
        await self._do(lambda database: database.execute(command, (*values.values(), run)))

    async def known(self) -> frozenset[str]:
        """The ids of all runs."""
        return frozenset(row[0] for row in await self._rows("SELECT run FROM runs"))

    async def sweep(self) -> None:
        """Remove what an executor before this one has left half done."""
        known = await self.known()
        for path in (self._folder / "runs").iterdir():
            left = path if path.name not in known else RunFolder(path).home
            if left.exists():
                await asyncio.to_thread(shutil.rmtree, left, ignore_errors=True)

    async def give_up_running(self) -> int:
        """Mark runs as lost that an executor before this one has left running; returns how many there were."""
        values = (State.LOST.value, time.time(), LOST, State.RUNNING.value)
        command = "UPDATE runs SET state = ?, ended = ?, reason = ? WHERE state = ?"
        return await self._do(lambda database: database.execute(command, values).rowcount)

    async def remove(self, run: str) -> None:
        """Forget a run, with its files; the folder goes first, so that none stays behind that nobody knows of.

        Raises:
            OSError: The folder cannot be removed; the run stays.
        """
        await asyncio.to_thread(_remove_folder, self.folder(run).path)
        await self._do(lambda database: database.execute("DELETE FROM runs WHERE run = ?", (run,)))


def _remove_folder(path: Path) -> None:
    """Remove a folder, if it is there, also where what a run has left in it is not to be written."""
    if not path.exists():
        return
    try:
        shutil.rmtree(path)
    except PermissionError:
        _make_writable(path)
        shutil.rmtree(path)


def _make_writable(folder: Path) -> None:
    """Make a folder writable, and those in and below it; links are not followed."""
    folders = [folder]
    while folders:
        each = folders.pop()
        each.chmod(0o700)
        with os.scandir(each) as found:
            folders += [Path(entry) for entry in found if entry.is_dir(follow_symlinks=False)]


@contextmanager
def open_store(folder: Path) -> Iterator[Store]:
    """Have a store for as long as the block lasts, alone.

    Raises:
        InvalidUse: It cannot be written, another executor uses it, or a newer version of seoro has made it.
    """
    try:
        for each in (folder, folder / "blobs", folder / "runs"):
            each.mkdir(parents=True, exist_ok=True, mode=0o700)
        lock = (folder / "executor.lock").open("w")
        sync_folder(folder)
        sync_folder(folder.absolute().parent)
    except OSError as error:
        raise InvalidUse(
            f"cannot keep runs in {folder}: {error.strerror}", help="`--folder` names another"
        ) from error
    with lock, ThreadPoolExecutor(1, "store") as thread:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise InvalidUse(
                f"another executor keeps its runs in {folder}", help="`--folder` names another folder"
            ) from None
        database = thread.submit(_open, folder / "runs.sqlite").result()
        try:
            yield Store(folder, database, thread)
        finally:
            thread.submit(database.close).result()


def _open(path: Path) -> sqlite3.Connection:
    try:
        database = sqlite3.connect(path)
        database.execute("PRAGMA journal_mode = WAL")
        database.execute("PRAGMA synchronous = FULL")  # what was acknowledged outlasts a loss of power
        database.execute(f"PRAGMA cache_size = -{CACHE}")
        version = database.execute("PRAGMA user_version").fetchone()[0]
        while version in _RENEWALS:
            renewal, version = _RENEWALS[version], version + 1
            database.executescript(f"BEGIN; {renewal} PRAGMA user_version = {version}; COMMIT;")
        if version == 0:
            database.executescript(f"BEGIN; {_TABLES} PRAGMA user_version = {SCHEMA}; COMMIT;")
        elif version != SCHEMA:
            database.close()
            raise InvalidUse(
                f"{path} was made by another version of seoro", help="`--folder` names another folder"
            )
    except sqlite3.DatabaseError as error:
        raise InvalidUse(f"cannot keep runs in {path}: {error}", help="`--folder` names another folder") from error
    return database


def _info(row: tuple[Any, ...]) -> RunInfo:
    return RunInfo.model_validate(dict(zip(_FIELDS.split(", "), row, strict=True)))
