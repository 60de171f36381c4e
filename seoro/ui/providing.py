"""Executors of a site: those of its endpoint, or else one of its own."""

from __future__ import annotations

import logging
import os
from pathlib import Path

import anyio

from seoro.client import VARIABLE
from seoro.concurrency.background import background
from seoro.errors import BackendError
from seoro.ui.executors import RETRY, Executors
from seoro.ui.places import Places
from seoro.ui.private_executor import NAME, SHOWN, private_executor
from seoro.ui.registry import RunRegistry
from seoro.ui.rights import Rights

log = logging.getLogger(__name__)


async def provide_executors(
    endpoint: str | None, keys: Path | None, state: Path, places: Places, registry: RunRegistry, rights: Rights
) -> None:
    """Add executors to the places of a site, in an endless loop.

    Args:
        endpoint: Endpoint of executors; None for the default one.
        keys: Folder of keys; None for that of the environment or of the user.
        state: Folder for runs of this machine.
        places: Places of the site.
        registry: Runs of the site.
        rights: Rights of its users; viewers get no executor of this machine.
    """
    is_chosen = endpoint is not None or VARIABLE in os.environ
    shared = Executors(endpoint, keys, {}, is_chosen=is_chosen)
    places.add(shared)
    async with background() as tasks:
        tasks.start_soon(shared.watch, registry)
        await shared.tried.wait()
        if not shared.names and rights.may_act:
            await provide_own(state, places, registry, rights)
        await anyio.sleep_forever()


async def provide_own(state: Path, places: Places, registry: RunRegistry, rights: Rights) -> None:
    """Add an executor of this machine to the places of a site, and start it again if it ends, in an endless loop.

    Args:
        state: Folder for its runs.
        places: Places of the site.
        registry: Runs of the site.
        rights: Rights of its users.
    """
    while True:
        try:
            await _run_own(state, places, registry, rights)
        except (BackendError, OSError) as error:
            log.error("%s", error)
        await anyio.sleep(RETRY)


async def _run_own(state: Path, places: Places, registry: RunRegistry, rights: Rights) -> None:
    """Provide the executor of this machine, until its process ends."""
    async with private_executor(state, is_trusted=rights.is_owner) as started:
        own = Executors(started.endpoint, None, {NAME: SHOWN})
        places.add(own)
        try:
            async with background() as tasks:
                tasks.start_soon(own.watch, registry)
                await started.process.wait()
                log.error("the executor of this machine ended, and is started again")
        finally:
            places.remove(own)
