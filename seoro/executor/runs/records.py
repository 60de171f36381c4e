"""Records, printed output and files of a run, as clients read them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

import anyio

from seoro.bridges.executor import messages as wire
from seoro.bridges.wire import encode
from seoro.concurrency.background import background
from seoro.executor.runs.active_run import ActiveRun
from seoro.executor.runs.tail import Watch, size_of, until_printed
from seoro.executor.storage.run_folder import open_left

PART: Final = wire.CHUNK // 2  # [bytes] of a trace in one reply, unless a line is longer


def is_news(live: ActiveRun, request: wire.AskRecords) -> bool:
    """Whether the run has changed since the state in the request."""
    info = live.info
    is_known = (info.state, bool(info.announcement)) == (request.state, request.is_announced)
    return live.size > request.at or not is_known or request.waits not in (None, info.waits)


async def watch_records(
    live: ActiveRun, request: wire.AskRecords, log: Path, send: Callable[[bytes], None]
) -> int:
    """Send new records until the run changes otherwise; returns the end of the sent part of the trace."""

    def send_part(start: int, lines: bytes) -> None:
        send(encode(wire.NewRecords(lines=lines, at=start + len(lines))))

    watch = Watch(request.at, wire.WINDOW, send_part)
    if not is_news(live, request):
        with live.watches.added(watch), anyio.move_on_after(request.wait):
            async with background() as looking:
                if request.printed_at is not None:
                    looking.start_soon(_end_when_printed, watch, log, request.printed_at)
                await watch.over.wait()
    return watch.at


async def _end_when_printed(watch: Watch, log: Path, at: int) -> None:
    await until_printed(log, at)
    watch.over.set()


def read_lines(trace: Path, at: int) -> tuple[bytes, bool]:
    """Return whole lines of a trace from a byte on, and whether they are the last."""
    try:
        with trace.open("rb") as file:
            size = os.fstat(file.fileno()).st_size
            file.seek(at)
            data = file.read(PART)
            if b"\n" not in data:
                data += file.readline()
            whole = data[: data.rfind(b"\n") + 1]
            # A line that was written in part when an executor died is skipped.
            return whole, at + len(data) >= size
    except FileNotFoundError:  # the run has not begun
        return b"", True


def read_printed(log: Path, at: int | None) -> tuple[bytes, bool]:
    """Return the printed output from a byte on, and whether it is the last; without `at`, nothing."""
    if at is None or size_of(log) <= at:
        return b"", True
    try:
        with open_left(log, log.parent) as file:
            file.seek(at)
            data = file.read(PART)
            return data, at + len(data) >= os.fstat(file.fileno()).st_size
    except OSError:  # removed or replaced by the run
        return b"", True


def list_outputs(folder: Path) -> Iterator[wire.OutputInfo]:
    """Yield the files in and below a folder; links are skipped."""
    for place, _, files in os.walk(folder):
        for name in files:
            path = Path(place, name)
            if path.is_file() and not path.is_symlink():
                yield wire.OutputInfo(path=path.relative_to(folder).as_posix(), size=path.stat().st_size)
