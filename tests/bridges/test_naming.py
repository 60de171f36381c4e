"""There is one node of a name: who asks for it must not reach now one and now another."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path

import anyio
import pytest

from seoro.background import background
from seoro.bridges.door import node_door
from seoro.bridges.session import AsyncSession, open_session
from seoro.bridges.wire.keys import NAMESPACE, node_token
from seoro.errors import InvalidUse

pytestmark = pytest.mark.anyio


@asynccontextmanager
async def served(_session: AsyncSession) -> AsyncIterator[None]:
    yield


async def come(endpoint: str, name: str, namespace: str = NAMESPACE) -> None:
    """Be a node for a moment."""
    async with background() as tasks:
        await tasks.start(node_door(None, endpoint, name, namespace).attend, served)


async def test_a_name_that_a_node_has_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/hub"
    async with open_session(listen=endpoint) as hub, hub.token(node_token(NAMESPACE, "floor", "1")):
        monkeypatch.setattr("seoro.bridges.naming.PATIENCE", 0.05)
        with pytest.raises(InvalidUse, match=r"there is a node 'floor' at unixsock-stream/.*/hub already"):
            await come(endpoint, "floor")
        await come(endpoint, "hall")
        await come(endpoint, "floor", "elsewhere")


async def test_a_name_is_had_once_who_had_it_is_gone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.bridges.naming.PATIENCE", 30.0)
    endpoint = f"unixsock-stream/{tmp_path}/hub"
    async with open_session(listen=endpoint) as hub, AsyncExitStack() as first:
        await first.enter_async_context(hub.token(node_token(NAMESPACE, "floor", "1")))
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(come, endpoint, "floor")
            await anyio.sleep(0.05)
            await first.aclose()
