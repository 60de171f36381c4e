"""A Zenoh router: what executors, simulators, bridges and their clients meet at."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import anyio

from seoro.background import background
from seoro.bridges.door import Door
from seoro.bridges.revoked import Revoked
from seoro.bridges.ros2.silent_peers import announce_silent_peers
from seoro.bridges.secured import ROUTING, keys_for
from seoro.bridges.session import AsyncSession, is_secured
from seoro.bridges.wire.limits import MAX_MESSAGE


async def route(endpoint: str, keys: Path | None, ready: Callable[[], None]) -> None:
    """Be a router; does not end. With keys, it lets pass what roles may, and starts anew when somebody is revoked.

    Without keys, peers that connect learn of each other, as nodes of ROS 2 need it. With keys, nobody learns the
    addresses of others: sessions of seoro are clients, and need none.

    Args:
        endpoint: Where it listens.
        keys: Folder of keys, for endpoints outside this machine; by default that of `SEORO_KEYS`, or of the user.
        ready: Called when it listens.

    Raises:
        InvalidUse: There are no keys, or they are not those of a router.
        SessionError: The endpoint does not work.
    """
    found = keys_for(endpoint, ROUTING, keys)
    revoked = None if found is None or not is_secured(endpoint) else Revoked(found)
    door = Door(endpoint, keys=found, revoked=revoked, gossip=not is_secured(endpoint), largest=MAX_MESSAGE)
    async with background() as tasks:
        await tasks.start(door.attend, _pass_on_nodes if door.gossip else _pass_on)
        ready()
        await anyio.sleep_forever()


@asynccontextmanager
async def _pass_on(_session: AsyncSession) -> AsyncIterator[None]:
    """All that a router does is done by Zenoh."""
    yield


@asynccontextmanager
async def _pass_on_nodes(session: AsyncSession) -> AsyncIterator[None]:
    """The same, for nodes of ROS 2, some of which need help."""
    async with background() as tasks:
        tasks.start_soon(announce_silent_peers, session)
        yield
