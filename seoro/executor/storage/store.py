"""Storage of runs: a table in SQLite, and a folder of files for each run.

- `executor.lock`: held while an executor uses the folder
- `runs.sqlite`: one row for each run
- `blobs/<hash>`: files of bundles
- `runs/<run>/`: `files/` (the bundle), `output/` (output files), `trace.jsonl`, `home/` (during the run)

One thread executes all commands of SQLite in order. Acknowledged changes are on the disk: a new run with its
bundle, its start, and its end with trace and output files.
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
from seoro.errors import UsageError
from seoro.executor.storage.run_folder import RunFolder
from seoro.files.durable import sync_folder

T = TypeVar("T")

CACHE: Final = 256  # [KiB] cache of the database
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
    end BLOB NOT NULL DEFAULT x'',       -- `seoro.embed.run_end`
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
class Finished:
    """End of a run: its state, reason, packed `seoro.embed.run_end`, time [s since 1970], SHA-256 of its trace."""

    state: State
    reason: str
    end: bytes
    ended: float
    trace: str = ""


class Store:
    """Stored runs. Created by `open_store`.

    Args:
        folder: Folder of the executor.
        database: Database of the runs.
        thread: Thread for commands of the database.
    """

    def __init__(self, folder: Path, database: sqlite3.Connection, thread: ThreadPoolExecutor) -> None:
        self._folder = folder
        self.blobs: Final = folder / "blobs"
        self._database = database
        self._thread = thread

    def folder(self, run: str) -> RunFolder:
        """Return the folder of a run."""
        return RunFolder(self._folder / "runs" / run)

    async def _do(self, work: Callable[[sqlite3.Connection], T]) -> T:
        def carry_out() -> T:
            with self._database:  # a transaction
                return work(self._database)

        return await asyncio.get_running_loop().run_in_executor(self._thread, carry_out)

    async def add(self, submission: wire.Submission) -> RunInfo:
        """Store a new run as queued, unless its id is known; returns the stored run."""
        values = (
            submission.run, submission.manifest.shown, submission.by, State.QUEUED.value, time.time(),
            encode(submission), submission.priority,
        )  # fmt: skip
        fields = "run, file, by, state, submitted, submission, priority"
        command = f"INSERT OR IGNORE INTO runs ({fields}) VALUES (?,?,?,?,?,?,?)"  # noqa: S608 - names of ours
        await self._do(lambda database: database.execute(command, values))
        return await self.info(submission.run)

    async def submission(self, run: str) -> wire.Submission:
        """Return the submission of a run."""
        [submission] = await self._column("submission", "run = ?", run)
        return wire.SUBMIT.read(submission)

    async def info(self, run: str) -> RunInfo:
        """Return the state of a run.

        Raises:
            KeyError: The id is unknown.
        """
        for info in await self._infos("run = ?", run):
            return info
        raise KeyError(run)

    async def end(self, run: str) -> bytes:
        """Return the packed end of a run; empty if it is unknown."""
        end: bytes
        [end] = await self._column("end", "run = ?", run)
        return end

    async def youngest(self, limit: int, prefix: str = "") -> tuple[RunInfo, ...]:
        """Return the most recent runs whose ids begin with `prefix`."""
        return await self._infos("run GLOB ? ORDER BY number DESC LIMIT ?", f"{prefix}*", limit)

    async def queued(self) -> tuple[str, ...]:
        """Return the ids of queued runs, oldest first."""
        return await self._column("run", "state = ? ORDER BY number", State.QUEUED.value)

    async def running(self) -> tuple[RunInfo, ...]:
        """Return running runs, and those of a previous executor that died."""
        return await self._infos("state = ? ORDER BY number", State.RUNNING.value)

    async def over(self, before: float) -> tuple[str, ...]:
        """Return the ids of runs that ended before a time."""
        return await self._column("run", "ended < ?", before)

    async def _infos(self, which: str, *values: object) -> tuple[RunInfo, ...]:
        rows = await self._rows(_FIELDS, which, *values)
        return tuple(RunInfo.model_validate(dict(zip(_FIELDS.split(", "), row, strict=True))) for row in rows)

    async def _column(self, field: str, which: str, *values: object) -> tuple[Any, ...]:
        return tuple(row[0] for row in await self._rows(field, which, *values))

    async def _rows(self, fields: str, which: str, *values: object) -> list[tuple[Any, ...]]:
        command = f"SELECT {fields} FROM runs WHERE {which}"  # noqa: S608 - names of ours
        return await self._do(lambda database: database.execute(command, values).fetchall())

    async def start(self, run: str) -> None:
        """Mark a run as running."""
        await self._set(run, state=State.RUNNING.value, started=time.time())

    async def wait(self, run: str) -> None:
        """Mark a run as queued again; if the executor dies, the next one starts it."""
        await self._set(run, state=State.QUEUED.value, started=None)

    async def announce(self, run: str, announcement: str) -> None:
        """Store the announcement of a run."""
        await self._set(run, announcement=announcement)

    async def finish(self, run: str, how: Finished) -> None:
        """Store the end of a run."""
        values = {"ended": how.ended, "reason": how.reason, "end": how.end, "trace": how.trace}
        await self._set(run, state=how.state.value, **values)

    async def _set(self, run: str, **values: object) -> None:
        assignments = ", ".join(f"{name} = ?" for name in values)
        command = f"UPDATE runs SET {assignments} WHERE run = ?"  # noqa: S608 - names of ours
        await self._do(lambda database: database.execute(command, (*values.values(), run)))

    async def known(self) -> frozenset[str]:
        """Return the ids of all runs."""
        return frozenset(await self._column("run", "TRUE"))

    async def sweep(self) -> None:
        """Remove incomplete folders of a previous executor."""
        known = await self.known()
        for path in (self._folder / "runs").iterdir():
            left = path if path.name not in known else RunFolder(path).home
            if left.exists():
                await asyncio.to_thread(shutil.rmtree, left, ignore_errors=True)

    async def mark_lost(self) -> int:
        """Mark the running runs of a previous executor as lost; returns their number."""
        values = (State.LOST.value, time.time(), LOST, State.RUNNING.value)
        command = "UPDATE runs SET state = ?, ended = ?, reason = ? WHERE state = ?"
        return await self._do(lambda database: database.execute(command, values).rowcount)

    async def remove(self, run: str) -> None:
        """Delete a run and its files; the folder first, so that no unknown folder remains.

        Raises:
            OSError: The folder cannot be removed; the run stays.
        """
        await asyncio.to_thread(_remove_folder, self.folder(run).path)
        await self._do(lambda database: database.execute("DELETE FROM runs WHERE run = ?", (run,)))


def _remove_folder(path: Path) -> None:
    """Remove a folder, if it exists, even with write-protected folders in it."""
    if not path.exists():
        return
    try:
        shutil.rmtree(path)
    except PermissionError:
        _make_writable(path)
        shutil.rmtree(path)


def _make_writable(folder: Path) -> None:
    """Make a folder and all below it writable; links are not followed."""
    folders = [folder]
    while folders:
        each = folders.pop()
        each.chmod(0o700)
        with os.scandir(each) as found:
            folders += [Path(entry) for entry in found if entry.is_dir(follow_symlinks=False)]


@contextmanager
def open_store(folder: Path) -> Iterator[Store]:
    """Open a store exclusively while the block lasts.

    Raises:
        UsageError: The folder cannot be written, is used by another executor, or is of another version of seoro.
    """
    try:
        for each in (folder, folder / "blobs", folder / "runs"):
            each.mkdir(parents=True, exist_ok=True, mode=0o700)
        lock = (folder / "executor.lock").open("w")
        sync_folder(folder)
        sync_folder(folder.absolute().parent)
    except OSError as error:
        is_file = isinstance(error, FileExistsError | NotADirectoryError)
        reason = f"{error.filename} is not a folder" if is_file else error.strerror
        raise UsageError(
            f"cannot store runs in {folder}: {reason}", help="choose another folder with `--folder`"
        ) from error
    with lock, ThreadPoolExecutor(1, "store") as thread:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise UsageError(
                f"another executor uses the folder {folder}", help="choose another folder with `--folder`"
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
        database.execute("PRAGMA synchronous = FULL")  # acknowledged changes survive a loss of power
        database.execute(f"PRAGMA cache_size = -{CACHE}")
        version = database.execute("PRAGMA user_version").fetchone()[0]
        while version in _RENEWALS:
            renewal, version = _RENEWALS[version], version + 1
            database.executescript(f"BEGIN; {renewal} PRAGMA user_version = {version}; COMMIT;")
        if version == 0:
            database.executescript(f"BEGIN; {_TABLES} PRAGMA user_version = {SCHEMA}; COMMIT;")
        elif version != SCHEMA:
            database.close()
            raise UsageError(
                f"{path} was created by another version of seoro", help="choose another folder with `--folder`"
            )
    except sqlite3.DatabaseError as error:
        raise UsageError(
            f"cannot store runs in {path}: {error}", help="choose another folder with `--folder`"
        ) from error
    return database
