"""Trace and output files of a run, on this machine or on an executor."""

from __future__ import annotations

from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import aclosing, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO, Final

import anyio
import anyio.to_thread

from seoro.client.runs import RemoteRun
from seoro.errors import UsageError
from seoro.files.inputs import Kind, open_input, read_input_text
from seoro.runtime.execution.outputs import INDEX, RESULT_NAMES, TRACE
from seoro.ui.answers import RequestError
from seoro.ui.registry import LocalSource, Source

MOST_FILES: Final = 1000
_OF_PAGES: Final = ("measurements.json", "coverage.json", "trajectories.csv")  # that pages of runs show
_LARGEST_OF_PAGES: Final = 64 << 20  # [bytes]
_CHUNK: Final = 1 << 20  # [bytes]


@dataclass(frozen=True)
class Result:
    """An output file of a run.

    Args:
        name: Its path in the folder of the run.
        size: Its size [bytes].
    """

    name: str
    size: int


async def list_results(source: Source) -> list[Result]:
    """Return the output files of a run, at most `MOST_FILES`, with its trace.

    Raises:
        BackendError: The executor does not answer.
    """
    if isinstance(source, LocalSource):
        return await anyio.to_thread.run_sync(_local_results, source)
    files = [Result(each.path, each.size) for each in await source.files()]
    return [Result(TRACE, -1), *(each for each in files[:MOST_FILES] if each.name != TRACE)]


def _local_results(source: LocalSource) -> list[Result]:
    if source.folder is None:
        return [Result(source.trace.name, source.trace.stat().st_size)]
    found = []
    for path in sorted(_below(source.folder)):
        if not path.is_symlink() and path.is_file():
            found.append(Result(path.relative_to(source.folder).as_posix(), path.stat().st_size))
        if len(found) >= MOST_FILES:
            break
    return found


def _below(folder: Path) -> set[Path]:
    """Return what a run left in its folder, which may have other files, too."""
    try:
        names = {*read_input_text(folder / INDEX, Kind.OUTPUT).splitlines(), TRACE}
    except (OSError, UnicodeDecodeError):
        names = set(RESULT_NAMES)
    own = [folder / name for name in names if name and Path(name).name == name and name != ".."]
    folders = [path for path in own if path.is_dir() and not path.is_symlink()]
    return {*own, *(path for each in folders for path in each.rglob("*"))}


async def read_result(source: Source, name: str) -> AsyncGenerator[bytes, None]:
    """Yield the parts of an output file.

    Args:
        source: The run.
        name: Its name in `list_results`.

    Raises:
        RequestError: The run has no such file.
        BackendError: The executor does not answer.
        OSError: The file cannot be read.
    """
    if name not in {each.name for each in await list_results(source)}:
        raise RequestError(404, "unknown output file of the run")
    if isinstance(source, RemoteRun):
        parts = source.lines_so_far() if name == TRACE else source.read_file(name)
        async with aclosing(parts):
            async for part in parts:
                yield part
        return
    path = source.trace if source.folder is None else source.folder / name
    file = await anyio.to_thread.run_sync(open_input, path, Kind.RECORDING)
    with file:
        while data := await anyio.to_thread.run_sync(file.read, _CHUNK):
            yield data


@asynccontextmanager
async def local_copy(source: Source, *, is_trace_only: bool = False) -> AsyncIterator[LocalSource]:
    """Provide a run as files of this machine while the block lasts.

    Args:
        source: The run; the trace of an active one ends with its last record so far.
        is_trace_only: Whether to leave out its other results.

    Raises:
        BackendError: The executor does not answer.
    """
    if isinstance(source, LocalSource):
        yield source
        return
    with TemporaryDirectory(prefix="seoro-") as name:
        folder = anyio.Path(name)
        async with await anyio.open_file(folder / TRACE, "wb") as file, aclosing(source.lines_so_far()) as parts:
            async for part in parts:
                await file.write(part)
        if not is_trace_only:
            await fetch_of_pages(source, Path(folder))
        yield LocalSource(Path(folder / TRACE), Path(folder))


async def fetch_of_pages(run: RemoteRun, folder: Path) -> None:
    """Download the small results that pages of runs show; missing ones are skipped.

    Raises:
        BackendError: The executor does not answer.
    """
    for each in await run.files():
        if each.path in _OF_PAGES and each.size <= _LARGEST_OF_PAGES:
            try:
                await run.fetch_file(each.path, folder / each.path)
            except UsageError as error:
                raise RequestError(500, error.message) from error


def open_trace(source: LocalSource) -> IO[bytes]:
    """Open the trace of a run.

    Raises:
        OSError: It cannot be read.
    """
    return open_input(source.trace, Kind.TRACE)
