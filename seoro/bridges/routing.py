"""A Zenoh router: what executors, simulators, bridges and their clients meet at."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path
from typing import Final

import anyio

from seoro.background import background
from seoro.bridges.revoked import Revoked
from seoro.bridges.secured import ROUTING, keys_for, security_of
from seoro.bridges.session import SessionError, is_secured, open_session

PAUSE: Final = 0.2  # [s] before an endpoint that does not open again is tried once more

log = logging.getLogger(__name__)


async def route(endpoint: str, keys: Path | None, ready: Callable[[], None]) -> None:
    """Be a router; does not end. With keys, it lets pass what roles may, and starts anew when somebody is revoked.

    Args:
        endpoint: Where it listens.
        keys: Folder of keys, for endpoints outside this machine; by default that of `SEORO_KEYS`, or of the user.
        ready: Called when it listens.

    Raises:
        InvalidUse: There are no keys, or they are not those of a router.
        SessionError: The endpoint does not work.
    """
    found = keys_for(endpoint, ROUTING, keys)
    if found is None or not is_secured(endpoint):
        async with open_session(listen=endpoint):
            ready()
            await anyio.sleep_forever()
            return
    revoked, is_open = Revoked(found), False
    async with background() as tasks:
        tasks.start_soon(revoked.follow)
        while True:
            known = revoked.current().seats
            try:
                security = security_of(endpoint, found, listens=True, revoked=known)
                async with open_session(listen=endpoint, security=security):
                    if not is_open:
                        ready()
                    is_open = True
                    await revoked.wait_for_change(known)
            except SessionError as error:
                if not is_open:
                    raise
                log.error("cannot listen: %s; trying again", error)
                await anyio.sleep(PAUSE)
