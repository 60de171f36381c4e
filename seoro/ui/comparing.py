"""Route of the comparison of two runs, as by `seoro compare`."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from typing import IO, Any

import anyio.to_thread
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route

from seoro.client.runs import RemoteRun
from seoro.errors import UsageError
from seoro.traces.comparison import NoBeginning, compare_runs
from seoro.traces.reader import InvalidRecord, Record, read_trace
from seoro.ui.answers import RequestError, answer
from seoro.ui.registry import Known
from seoro.ui.results import local_copy, open_trace
from seoro.ui.site import Site


def routes(site: Site) -> list[BaseRoute]:
    """Return the route of comparisons."""

    async def compare(request: Request) -> Response:
        ids = [_id_in(request, name) for name in ("a", "b")]
        first, second = (site.runs.get(each) for each in ids)
        async with _opened(first) as one, _opened(second) as other:
            found = await anyio.to_thread.run_sync(_compare, one, other)
        return answer({**found, "a": ids[0], "b": ids[1]})

    return [Route("/api/compare", compare)]


def _id_in(request: Request, name: str) -> str:
    found = request.query_params.get(name)
    if not found:
        raise RequestError(400, f"missing `{name}` of the comparison", "choose two runs in the list", name)
    return found


@asynccontextmanager
async def _opened(known: Known) -> AsyncIterator[IO[bytes]]:
    """Open the trace of a run; that of an executor is fetched."""
    if not known.run.status.is_final and isinstance(known.source, RemoteRun):
        raise RequestError(409, f"the run of {known.run.scenario} has not ended", "compare it when it has ended")
    async with local_copy(known.source, is_trace_only=True) as source:
        try:
            file = open_trace(source)
        except OSError as error:
            raise UsageError(f"cannot read the trace of {known.run.scenario}: {error.strerror}") from error
        with file:
            yield file


def _compare(first: IO[bytes], second: IO[bytes]) -> dict[str, Any]:
    try:
        return compare_runs(_records(first), _records(second)).data
    except NoBeginning as error:
        raise UsageError(
            f"the trace of the {('first', 'second')[error.index]} run has no beginning", help="compare whole runs"
        ) from error


def _records(file: IO[bytes]) -> Iterator[Record]:
    for found in read_trace(file):
        if not isinstance(found, InvalidRecord):
            yield found
        elif not found.is_cut:  # the last line of a killed or active run may be
            raise UsageError(f"invalid trace: {found}")
