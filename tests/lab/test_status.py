"""Connections to the endpoints of a lab."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest

from seoro.bridges.session import AsyncSession, open_session
from seoro.lab import status
from seoro.lab.status import connect_members

pytestmark = pytest.mark.anyio


async def test_all_endpoints_are_queried_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    nowhere, hub = (f"unixsock-stream/{tmp_path}/{name}" for name in ("nowhere", "hub"))
    tried: set[str] = set()
    all_tried = anyio.Event()

    @asynccontextmanager
    async def opening(*, connect: str, security: None) -> AsyncIterator[AsyncSession]:
        tried.add(connect)
        if tried == {nowhere, hub}:
            all_tried.set()
        await all_tried.wait()
        async with open_session(connect=connect, security=security) as session:
            yield session

    monkeypatch.setattr(status, "open_session", opening)
    with anyio.fail_after(30.0):
        async with open_session(listen=hub), connect_members([nowhere, hub, nowhere]) as reached:
            assert [(each.member.endpoint, each.session is None) for each in reached] == [
                (nowhere, True),
                (hub, False),
            ]
            assert "cannot connect" in reached[0].member.problem
            assert "no node or executor" in reached[1].member.problem
