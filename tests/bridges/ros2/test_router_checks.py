"""Peers of routers whose ROS 2 nodes are not announced."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest

from seoro.bridges.ros2.errors import NoSystem
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.router_checks import hidden_peers
from seoro.bridges.session import AsyncSession, Bound, open_session
from seoro.concurrency.background import background

pytestmark = pytest.mark.anyio

PEER = "5e1f"


@asynccontextmanager
async def described_router(router: str, answer: bytes) -> AsyncIterator[AsyncSession]:
    """Yield a session at a router whose administration space has an answer."""
    async with (
        open_session(connect=router) as space,
        space.answering("@/feed/router", Bound(8), b"busy") as requests,
        open_session(connect=router) as session,
        background() as tasks,
    ):

        async def reply() -> None:
            async for request in requests:
                request.reply(answer)

        tasks.start_soon(reply)
        yield session


def described(version: str, *kinds: str) -> bytes:
    sessions: list[Any] = [{"peer": f"{PEER}{index}", "whatami": kind} for index, kind in enumerate(kinds)]
    return json.dumps({"version": version, "sessions": sessions}).encode()


@pytest.mark.parametrize(
    "answer", [b"no JSON", b"[]", b"{}", b'{"sessions": 1}', b'{"version": "v1.10.2-g", "sessions": [1]}']
)
async def test_odd_answers_are_ignored(router: str, answer: bytes) -> None:
    async with described_router(router, answer) as session:
        assert await hidden_peers(session) == ""


@pytest.mark.parametrize(
    ("answer", "text"),
    [
        (described("v1.10.2-abc built", "peer", "client"), "the router (Zenoh 1.10) has 1 connected peer without"),
        (described("v1.9.0", "peer", "peer"), "the router (Zenoh 1.9) has 2 connected peers without"),
        (described("v1.8.0-abc", "peer"), ""),
        (described("v1.10.2", "client", "router"), ""),
    ],
)
async def test_peers_without_nodes_are_described(router: str, answer: bytes, text: str) -> None:
    async with described_router(router, answer) as session:
        found = await hidden_peers(session)
        assert found.startswith(text)
        assert bool(found) == bool(text)


async def test_peers_with_nodes_are_visible(router: str) -> None:
    async with (
        described_router(router, described("v1.10.2", "peer")) as session,
        session.token(f"@ros2_lv/0/{PEER}0/0/0/NN/%/%/driver"),
    ):
        assert await hidden_peers(session) == ""


async def test_a_missing_system_is_explained(router: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.bridges.ros2.participant.DISCOVERY_TIMEOUT", 0.1)
    async with described_router(router, described("v1.10.2", "peer")):
        with pytest.raises(NoSystem, match=r"1 connected peer without visible .*: restart these nodes, or run"):
            async with connect(router):
                pass
