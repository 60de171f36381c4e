"""Opening of a site, and serving of its pages."""

from __future__ import annotations

import contextlib
import errno
import socket
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import anyio
import uvicorn
from starlette.types import ASGIApp

from seoro.concurrency.background import background
from seoro.errors import UsageError
from seoro.lab.reading import read_lab
from seoro.ui.application import make_application
from seoro.ui.feeds import Feeds
from seoro.ui.local_runs import LocalRuns
from seoro.ui.places import Places
from seoro.ui.providing import provide_executors
from seoro.ui.registry import RunRegistry
from seoro.ui.scenario_files import ScenarioFiles
from seoro.ui.security import Access
from seoro.ui.site import Site
from seoro.ui.sockets import LARGEST_MESSAGE

PORT: Final = 7480
LOOPBACK: Final = "127.0.0.1"
_LAST_ANSWERS: Final = 2  # [s] for pending requests at the end


@dataclass(frozen=True)
class SiteOptions:
    """Settings of a site.

    Args:
        folders: Folders with runs, scenarios and campaigns.
        endpoint: Endpoint of executors; None for the default one.
        keys: Folder of keys; None for that of the environment or of the user.
        port: Port; 0 for a free one.
        state: Folder for runs of this machine that the site starts.
        lab: Lab file; None for none.
    """

    folders: tuple[Path, ...]
    state: Path
    endpoint: str | None = None
    keys: Path | None = None
    port: int = PORT
    lab: Path | None = None


@dataclass(frozen=True)
class Served:
    """A served site.

    Args:
        site: The site.
        access: Its addresses and secrets.
    """

    site: Site
    access: Access


@asynccontextmanager
async def open_site(options: SiteOptions) -> AsyncIterator[Served]:
    """Serve a site while the block lasts.

    Raises:
        UsageError: A folder is missing, the port is in use, or the lab file is invalid.
    """
    folders = tuple(_checked(folder) for folder in options.folders)
    lab = None if options.lab is None else read_lab(options.lab)
    with _listening(LOOPBACK, options.port) as listener:
        access = Access("http", (LOOPBACK, "localhost"), listener.getsockname()[1])
        async with background() as tasks:
            registry = RunRegistry()
            feeds = Feeds(registry, tasks)
            places = Places(folders)
            site = Site(folders, options.keys, places, registry, feeds, ScenarioFiles(folders), tasks, lab)
            tasks.start_soon(provide_executors, options.endpoint, options.keys, options.state, places, registry)
            tasks.start_soon(LocalRuns(folders).watch, registry)
            tasks.start_soon(feeds.forget_unused)
            async with _serving(make_application(site, access), listener):
                yield Served(site, access)


class _Server(uvicorn.Server):
    """A server that leaves signals to its command."""

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield


@asynccontextmanager
async def _serving(application: ASGIApp, listener: socket.socket) -> AsyncIterator[None]:
    config = uvicorn.Config(
        application,
        access_log=False,
        date_header=False,
        lifespan="off",
        log_config=None,
        log_level="critical",  # the application logs its errors
        proxy_headers=False,
        server_header=False,
        timeout_graceful_shutdown=_LAST_ANSWERS,
        ws_max_size=LARGEST_MESSAGE,
        ws_per_message_deflate=False,
    )
    server = _Server(config)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(server.serve, [listener])
        try:
            yield
        finally:
            server.should_exit = True


def _checked(folder: Path) -> Path:
    found = folder.resolve()
    if not found.is_dir():
        what = "is not a folder" if found.exists() else "does not exist"
        raise UsageError(f"{folder} {what}", help="name folders with runs or scenarios")
    return found


@contextlib.contextmanager
def _listening(host: str, port: int) -> Iterator[socket.socket]:
    try:
        listener = socket.create_server((host, port))
    except (OSError, OverflowError) as error:
        if isinstance(error, OSError) and error.errno == errno.EADDRINUSE:
            raise UsageError(
                f"port {port} is in use", help="choose another one with `--port N`; 0 for a free one"
            ) from None
        raise UsageError(f"cannot listen at {host}:{port}: {error}", help="choose another port") from None
    with listener:
        yield listener
