"""Zenoh router that connects executors, simulators, bridges and their clients."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import anyio

from seoro.bridges.ros2.silent_peers import announce_silent_peers
from seoro.bridges.session import AsyncSession, is_secured
from seoro.bridges.wire.limits import MAX_MESSAGE
from seoro.concurrency.background import background
from seoro.security.network.endpoint_keys import ROUTING, keys_for
from seoro.security.network.listener import Listener
from seoro.security.network.revocation_monitor import RevocationMonitor


async def run_router(endpoint: str, keys: Path | None, ready: Callable[[], None]) -> None:
    """Run a router; does not return. With keys, it enforces the roles, and restarts when keys are revoked.

    Without keys, peers discover each other, as nodes of ROS 2 require. With keys, addresses of peers stay private:
    sessions of seoro are clients, and need none.

    Args:
        endpoint: Endpoint of the router.
        keys: Folder of keys, for endpoints outside this machine; by default `SEORO_KEYS`, or that of the user.
        ready: Called when the router listens.

    Raises:
        UsageError: The keys are missing, or do not have the role `router`.
        SessionError: The endpoint does not work.
    """
    found = keys_for(endpoint, ROUTING, keys)
    revoked = None if found is None or not is_secured(endpoint) else RevocationMonitor(found)
    listener = Listener(
        endpoint, keys=found, revoked=revoked, gossip=not is_secured(endpoint), largest=MAX_MESSAGE
    )
    async with background() as tasks:
        await tasks.start(listener.serve, _serve_ros if listener.gossip else _serve)
        ready()
        await anyio.sleep_forever()


@asynccontextmanager
async def _serve(_session: AsyncSession) -> AsyncIterator[None]:
    """Serve a session; Zenoh routes the messages."""
    yield


@asynccontextmanager
async def _serve_ros(session: AsyncSession) -> AsyncIterator[None]:
    """Announce nodes of ROS 2 that do not announce themselves, while the block lasts."""
    async with background() as tasks:
        tasks.start_soon(announce_silent_peers, session)
        yield
