"""Nodes without announcements to their router: the router queries and announces them."""

from __future__ import annotations

import logging
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass

import anyio
import pytest

from seoro.bridges.ros2 import silent_peers
from seoro.bridges.ros2.silent_peers import announce_silent_peers
from seoro.bridges.session import AsyncSession, open_session
from seoro.concurrency.background import background
from tests.bridges.ros2.peers import peer
from tests.routers import free_endpoint

pytestmark = pytest.mark.anyio

DEADLINE = 30.0  # [s]


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(silent_peers, "PERIOD", 0.02)


@dataclass(frozen=True)
class Watched:
    """A router: endpoint, session, tokens at one of its clients, and the start of its queries."""

    endpoint: str
    session: AsyncSession
    changes: AsyncIterator[tuple[str, bool]]
    look: Callable[[], object]


@asynccontextmanager
async def watched_router() -> AsyncIterator[Watched]:
    """Yield a router with a client."""
    endpoint = free_endpoint()
    async with (
        open_session(listen=endpoint, gossip=True) as router,
        background() as tasks,
        open_session(connect=endpoint) as client,
        client.tokens("@ros2_lv/**") as changes,
    ):
        with anyio.fail_after(DEADLINE):
            yield Watched(endpoint, router, changes, lambda: tasks.start_soon(announce_silent_peers, router))


async def test_nodes_without_announcements_are_added_and_removed() -> None:
    async with watched_router() as router:
        changes = router.changes
        with peer(router.endpoint, silent_to=router.session.identity) as node:
            key = f"@ros2_lv/0/{node.zid()}"
            first = node.liveliness().declare_token(f"{key}/0/0/NN/%/%/robot")
            router.look()
            assert await anext(changes) == (f"{key}/0/0/NN/%/%/robot", True)
            second = node.liveliness().declare_token(f"{key}/0/1/MP/%/%/robot")
            assert await anext(changes) == (f"{key}/0/1/MP/%/%/robot", True)
            second.undeclare()  # type: ignore[no-untyped-call]
            assert await anext(changes) == (f"{key}/0/1/MP/%/%/robot", False)
        assert await anext(changes) == (f"{key}/0/0/NN/%/%/robot", False)
        del first


async def test_nodes_with_announcements_are_not_queried(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = anyio.Event()

    async def announce(*_arguments: object) -> None:
        raise AssertionError("it announces itself")

    monkeypatch.setattr(silent_peers, "_announce", announce)

    @asynccontextmanager
    async def open_near(*, connect: str, as_peer: bool) -> AsyncIterator[AsyncSession]:
        async with open_session(connect=connect, as_peer=as_peer) as near:
            yield near
        asked.set()

    monkeypatch.setattr(silent_peers, "open_session", open_near)
    async with watched_router() as router:
        with peer(router.endpoint) as node:
            token = node.liveliness().declare_token(f"@ros2_lv/0/{node.zid()}/0/0/NN/%/%/robot")
            assert (await anext(router.changes))[1]
            router.look()
            await asked.wait()
            del token


async def test_nodes_that_cannot_be_queried_are_reported(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING)
    monkeypatch.setattr(silent_peers, "is_local", lambda _: False)
    async with watched_router() as router:
        with peer(router.endpoint, silent_to=router.session.identity) as node:
            router.look()
            while "announces no ROS 2 node" not in caplog.text:
                await anyio.sleep(0.01)
            assert str(node.zid()) in caplog.text
            assert "restart them" in caplog.text
