"""Opening of a site, and serving of its pages."""

from __future__ import annotations

import contextlib
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import anyio
import uvicorn
from starlette.types import ASGIApp

from seoro.concurrency.background import background
from seoro.errors import UsageError
from seoro.lab.reading import read_lab
from seoro.ui.application import make_application
from seoro.ui.examples import start_examples
from seoro.ui.feeds import Feeds
from seoro.ui.listening import Address, Endpoint, listening
from seoro.ui.local_runs import LocalRuns
from seoro.ui.places import Places
from seoro.ui.providing import provide_executors, provide_own
from seoro.ui.registry import RunRegistry
from seoro.ui.rights import Rights
from seoro.ui.scenario_files import ScenarioFiles
from seoro.ui.security import Access
from seoro.ui.site import Site
from seoro.ui.sockets import LARGEST_MESSAGE

_LAST_ANSWERS: Final = 2  # [s] for pending requests at the end


@dataclass(frozen=True)
class SiteOptions:
    """Settings of a site.

    Args:
        folders: Folders with runs, scenarios and campaigns.
        endpoint: Endpoint of executors; None for the default one.
        keys: Folder of keys; None for that of the environment or of the user.
        address: Address to listen at.
        state: Folder for runs of this machine that the site starts.
        lab: Lab file; None for none.
        is_demo: Whether to start the examples.
        certificate: Folder of keys with the role `site`, for addresses outside this machine.
    """

    folders: tuple[Path, ...]
    state: Path
    endpoint: str | None = None
    keys: Path | None = None
    address: Address = field(default_factory=Address)
    lab: Path | None = None
    is_demo: bool = False
    certificate: Path | None = None


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
        UsageError: A folder is missing, the lab file is invalid, or as `listening`.
    """
    folders = tuple(_checked(folder) for folder in options.folders)
    lab = None if options.lab is None else read_lab(options.lab)
    with listening(options.address, options.certificate, options.keys) as endpoint:
        rights = Rights.of(endpoint.role)
        async with background() as tasks:
            registry = RunRegistry()
            feeds = Feeds(registry, tasks)
            places = Places(folders)
            scenarios = ScenarioFiles(folders)
            site = Site(
                folders,
                options.state,
                options.keys,
                places,
                registry,
                feeds,
                scenarios,
                tasks,
                lab,
                options.is_demo,
                rights,
            )
            if not options.is_demo:
                tasks.start_soon(
                    provide_executors, options.endpoint, options.keys, options.state, places, registry, rights
                )
            else:
                tasks.start_soon(provide_own, options.state, places, registry, rights)
                tasks.start_soon(start_examples, site)
            tasks.start_soon(LocalRuns(folders).watch, registry)
            tasks.start_soon(feeds.forget_unused)
            async with _serving(make_application(site, endpoint.access), endpoint):
                yield Served(site, endpoint.access)


class _Server(uvicorn.Server):
    """A server that leaves signals to its command."""

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield


@asynccontextmanager
async def _serving(application: ASGIApp, endpoint: Endpoint) -> AsyncIterator[None]:
    keys = endpoint.certificate
    config = uvicorn.Config(
        application,
        access_log=False,
        date_header=False,
        lifespan="off",
        log_config=None,
        log_level="critical",  # the application logs its errors
        proxy_headers=False,
        server_header=False,
        ssl_certfile=None if keys is None else keys.certificate,
        ssl_keyfile=None if keys is None else keys.key,
        timeout_graceful_shutdown=_LAST_ANSWERS,
        ws_max_size=LARGEST_MESSAGE,
        ws_per_message_deflate=False,
    )
    server = _Server(config)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(server.serve, [endpoint.listener])
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
