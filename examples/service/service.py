"""A service that runs the scenarios of a folder.

    python service.py --folder scenarios

    POST   /runs               {"scenario": "patrol.osc", "parameters": {"pause": "1s"}}  starts a run
    GET    /runs/{id}          returns its status, and its verdict at the end
    GET    /runs/{id}/trace    streams its trace as server-sent events
    DELETE /runs/{id}          stops it, and waits for its clean-up

A client can run any scenario of the folder, with its Python. So the service listens on this machine only, and
limits the number of runs, their time, and the number of kept runs.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import logging
import secrets
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import uvicorn
from fastapi import FastAPI, Header, HTTPException, Request, Response
from fastapi.responses import StreamingResponse
from pydantic import BaseModel, ConfigDict, Field
from starlette.middleware.trustedhost import TrustedHostMiddleware

import seoro

HOSTS = ["127.0.0.1", "localhost"]  # other names in requests of web pages are refused
MAX_BODY = 64 * 1024  # [bytes]
MAX_RECORDS = 100_000  # of a trace, about 50 MB


@dataclass(frozen=True)
class Limits:
    """Limits of the service.

    Args:
        running: Number of simultaneous runs.
        kept: Number of ended runs that are kept.
        seconds: Wall time of a run [s].
    """

    running: int = 4
    kept: int = 50
    seconds: float = 600.0


class Order(BaseModel):
    """Request to run a scenario."""

    model_config = ConfigDict(extra="forbid")

    scenario: str = Field(max_length=200, description="file in the folder")
    name: str | None = Field(None, max_length=200, description="of the scenario, if the file has several")
    parameters: dict[str, Annotated[str, Field(max_length=1000)]] = Field({}, max_length=50)
    seed: int | None = Field(None, ge=0, lt=2**63)
    clock: Literal["real", "virtual"] = "virtual"


@dataclass(eq=False)
class Entry:
    """A known run."""

    order: Order
    started: asyncio.Future[seoro.Run] = field(default_factory=asyncio.Future)
    ended: asyncio.Event = field(default_factory=asyncio.Event)

    def describe(self, number: str) -> dict[str, Any]:
        """Return the state of the run as plain data."""
        run = self.started.result()
        return {
            "id": number,
            "scenario": self.order.scenario,
            "seed": run.seed,
            "parameters": run.parameters,
            "status": "running" if run.verdict is None else run.verdict.status.value,
            "reason": "" if run.verdict is None else run.verdict.reason,
        }


class Runs:
    """All runs of the service.

    Args:
        folder: Folder of the scenarios.
        limits: Limits of the service.
        group: Task group of the runs.
    """

    def __init__(self, folder: Path, limits: Limits, group: asyncio.TaskGroup) -> None:
        self._folder = folder
        self._limits = limits
        self._group = group
        self._entries: dict[str, Entry] = {}

    def files(self) -> dict[str, Path]:
        """Return the scenario files by name; only these can be run."""
        return {path.relative_to(self._folder).as_posix(): path for path in sorted(self._folder.rglob("*.osc"))}

    def all(self) -> dict[str, Entry]:
        """Return the started runs by id."""
        return {number: entry for number, entry in self._entries.items() if entry.started.done()}

    def get(self, number: str) -> Entry:
        """Return a started run; raise a client error if it is unknown."""
        if number not in self.all():
            raise HTTPException(404, f"unknown run {number!r}")
        return self._entries[number]

    async def start(self, order: Order) -> tuple[str, Entry]:
        """Start a run; raise a client error if that is impossible."""
        path = self.files().get(order.scenario)
        if path is None:
            raise HTTPException(404, f"unknown scenario file {order.scenario!r}")
        if sum(not entry.ended.is_set() for entry in self._entries.values()) >= self._limits.running:
            raise HTTPException(429, f"too many active runs (limit {self._limits.running})")
        number, entry = secrets.token_hex(8), Entry(order)
        self._entries[number] = entry
        self._group.create_task(self._carry(path, entry))
        try:
            await asyncio.shield(entry.started)
        except Exception as error:
            del self._entries[number]
            if isinstance(error, seoro.SeoroError):
                raise HTTPException(422, str(error)) from error
            raise
        self._forget()
        return number, entry

    async def _carry(self, path: Path, entry: Entry) -> None:
        """Execute a run, from its text to its verdict."""
        order = entry.order
        try:
            scenario = await asyncio.to_thread(seoro.load, path)
            watch = Watch()
            async with seoro.start(
                scenario,
                name=order.name,
                seed=order.seed,
                overrides=order.parameters,
                clock=order.clock,
                observers=[watch],
                keep_trace=True,
            ) as run:
                watch.run = run
                entry.started.set_result(run)
                try:
                    async with asyncio.timeout(self._limits.seconds):
                        await run.result()
                except TimeoutError:
                    run.stop(f"it takes more than {self._limits.seconds:g} s")
                    await run.result()
        except Exception as error:
            if entry.started.done():
                logging.exception("the run of %s broke down", order.scenario)
            else:
                entry.started.set_exception(error)
        finally:
            entry.ended.set()

    def _forget(self) -> None:
        """Forget the oldest runs that have ended and are too many."""
        ended = [number for number, entry in self._entries.items() if entry.ended.is_set()]
        for number in ended[: max(0, len(ended) - self._limits.kept)]:
            del self._entries[number]

    async def stop(self, number: str) -> None:
        """Stop a run, and wait until it has cleaned up."""
        entry = self._entries[number]
        entry.started.result().stop("stopped by a client")
        await entry.ended.wait()

    async def stop_all(self) -> None:
        """Stop all runs, which ends their traces and streams."""
        for entry in self.all().values():
            entry.started.result().stop("the service is shut down")
        for entry in list(self._entries.values()):
            await entry.ended.wait()


class Watch:
    """Observes the trace of a run, and stops the run when the trace grows too long."""

    def __init__(self) -> None:
        self.run: seoro.Run | None = None

    def record(self, record: dict[str, Any]) -> None:
        """Observe a record of the trace."""
        if record["seq"] == MAX_RECORDS and self.run is not None:
            self.run.stop(f"its trace has more than {MAX_RECORDS} records")


# ---------------------------------------------------------------- HTTP


def create_app(folder: Path, limits: Limits | None = None) -> FastAPI:
    """Make the service.

    Args:
        folder: Folder of the scenarios.
        limits: Limits of the service.
    """

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        async with asyncio.TaskGroup() as group:
            app.state.runs = Runs(root, limits or Limits(), group)
            yield
            await app.state.runs.stop_all()

    root = folder.resolve(strict=True)
    app = FastAPI(title="Scenarios", lifespan=lifespan)
    app.add_middleware(TrustedHostMiddleware, allowed_hosts=HOSTS)
    app.middleware("http")(_limit_body)
    app.get("/scenarios")(list_scenarios)
    app.post("/runs", status_code=201)(start_run)
    app.get("/runs")(list_runs)
    app.get("/runs/{number}")(get_run)
    app.get("/runs/{number}/trace")(get_trace)
    app.delete("/runs/{number}")(stop_run)
    return app


async def _limit_body(request: Request, call_next: Any) -> Response:
    size = request.headers.get("content-length", "0")
    if request.headers.get("transfer-encoding") or not size.isdecimal() or int(size) > MAX_BODY:
        return Response(f"expected a request with `Content-Length`, at most {MAX_BODY} bytes", status_code=413)
    response: Response = await call_next(request)
    return response


def _runs(request: Request) -> Runs:
    runs: Runs = request.app.state.runs
    return runs


async def list_scenarios(request: Request) -> list[str]:
    """Return the files that can be run."""
    return list(_runs(request).files())


async def start_run(request: Request, order: Order) -> dict[str, Any]:
    """Start a run."""
    number, entry = await _runs(request).start(order)
    return entry.describe(number)


async def list_runs(request: Request) -> list[dict[str, Any]]:
    """Return all known runs."""
    return [entry.describe(number) for number, entry in _runs(request).all().items()]


async def get_run(request: Request, number: str) -> dict[str, Any]:
    """Return the state of a run."""
    return _runs(request).get(number).describe(number)


async def stop_run(request: Request, number: str) -> dict[str, Any]:
    """Stop a run."""
    entry = _runs(request).get(number)
    await _runs(request).stop(number)
    return entry.describe(number)


async def get_trace(
    request: Request, number: str, last_event_id: Annotated[int, Header()] = -1
) -> StreamingResponse:
    """Stream the trace of a run as server-sent events; clients can reconnect without a gap."""
    run = _runs(request).get(number).started.result()

    async def events() -> AsyncIterator[str]:
        async for record in run.trace():
            if record["seq"] > last_event_id:
                yield f"id: {record['seq']}\ndata: {json.dumps(record, ensure_ascii=False)}\n\n"

    return StreamingResponse(events(), media_type="text/event-stream", headers={"Cache-Control": "no-store"})


class Server(uvicorn.Server):
    """Server that stops the runs before it waits for connections, which last as long as their runs."""

    async def shutdown(self, sockets: Any = None) -> None:
        """Shut down; called by uvicorn."""
        app = self.config.app
        if isinstance(app, FastAPI) and hasattr(app.state, "runs"):
            await app.state.runs.stop_all()
        await super().shutdown(sockets)


def main() -> None:
    """Serve until SIGINT or SIGTERM."""
    parser = argparse.ArgumentParser(description="Run the scenarios of a folder over HTTP, for this machine.")
    parser.add_argument("--folder", type=Path, required=True, help="folder with the scenario files")
    parser.add_argument("--port", type=int, default=8000, help="port to listen on; 0 for any (default: 8000)")
    options = parser.parse_args()
    if not options.folder.is_dir():
        parser.error(f"folder not found: {options.folder}")
    app = create_app(options.folder)
    Server(uvicorn.Config(app, host=HOSTS[0], port=options.port, timeout_graceful_shutdown=5)).run()


if __name__ == "__main__":
    main()
