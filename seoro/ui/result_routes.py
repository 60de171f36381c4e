"""Routes of the results of a run: its report, and its output files."""

from __future__ import annotations

from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import aclosing
from io import TextIOWrapper
from tempfile import TemporaryFile
from typing import IO, Final
from urllib.parse import quote

import anyio.to_thread
from starlette.requests import Request
from starlette.responses import Response, StreamingResponse
from starlette.routing import BaseRoute, Route

from seoro.report.page import NoRecords, write_report
from seoro.ui.answers import RequestError, answer
from seoro.ui.registry import LocalSource, Run, Source
from seoro.ui.results import list_results, local_copy, open_trace, read_result
from seoro.ui.site import Site

_CHUNK: Final = 1 << 20  # [bytes]
_BYTES: Final = "application/octet-stream"  # browsers save it, and never show it as a page


def routes(site: Site) -> list[BaseRoute]:
    """Return the routes of results."""

    async def list_files(request: Request) -> Response:
        known = site.runs.get(request.path_params["run"])
        return answer({"files": [vars(each) for each in await list_results(known.source)]})

    async def read_file(request: Request) -> Response:
        name = request.path_params["name"]
        parts = read_result(site.runs.get(request.path_params["run"]).source, name)
        return await _download(parts, name.rpartition("/")[2])

    async def report(request: Request) -> Response:
        known = site.runs.get(request.path_params["run"])
        return await _download(_report(known.source), _report_name(known.run))

    return [
        Route("/api/run/{run}/files", list_files),
        Route("/api/run/{run}/files/{name:path}", read_file),
        Route("/api/run/{run}/report", report),
    ]


async def _report(source: Source) -> AsyncGenerator[bytes, None]:
    """Yield the parts of a report.

    Raises:
        RequestError: The trace has no records yet.
        BackendError: The executor does not answer.
        OSError: The trace cannot be read.
    """
    with TemporaryFile() as file:
        async with local_copy(source) as local:
            try:
                await anyio.to_thread.run_sync(_write_report, local, file)
            except NoRecords as error:
                raise RequestError(409, f"no report: {error}", "try again when the run has started") from None
        while data := await anyio.to_thread.run_sync(file.read, _CHUNK):
            yield data


def _write_report(source: LocalSource, file: IO[bytes]) -> None:
    with open_trace(source) as trace:
        text = TextIOWrapper(file, encoding="utf-8", newline="\n")
        write_report(trace, source.folder, text, space=True)
        text.flush()
        text.detach()
    file.seek(0)


def _report_name(run: Run) -> str:
    return f"{run.scenario or 'run'}-{run.id[:8]}.html"


async def _download(parts: AsyncGenerator[bytes, None], name: str) -> Response:
    """Answer with a file; its first part is read before, so that errors have their status."""
    first = await anext(parts, b"")

    async def all_parts() -> AsyncIterator[bytes]:
        async with aclosing(parts):
            yield first
            async for part in parts:
                yield part

    headers = {"content-disposition": f"attachment; filename*=UTF-8''{quote(name, safe='')}"}
    return StreamingResponse(all_parts(), media_type=_BYTES, headers=headers)
