"""There is one node of a name: who asks for it must not reach now one and now another."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import replace
from pathlib import Path

import anyio
import pytest

from seoro.background import background
from seoro.bridges.door import Door, node_door
from seoro.bridges.revoked import Revoked
from seoro.bridges.session import AsyncSession, Bound, open_session
from seoro.bridges.wire.keys import NAMESPACE, node_command, node_token
from seoro.bridges.wire.message import decode, encode
from seoro.bridges.wire.proving import Challenge, Proof
from seoro.errors import InvalidUse
from seoro.keys.folder import Keys, read_keys
from seoro.keys.roles import Role
from seoro.keys.sealing import prove
from seoro.keys.signing import certificate_der
from seoro.steady import steady_ns
from tests.labs import make_lab

pytestmark = pytest.mark.anyio
EXCHANGE = b"1" * 32


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


@asynccontextmanager
async def proving(session: AsyncSession, keys: Keys) -> AsyncIterator[None]:
    """Answer those who challenge the node 'maze'."""

    async def prove_all() -> None:
        async for request in requests:
            nonce, now = decode(Challenge, request.payload).nonce, steady_ns()
            signature = prove(keys, "maze", nonce, "b00t", now, EXCHANGE)
            certificate = certificate_der(keys.certificate)
            parts = {"certificate": certificate, "signature": signature, "exchange": EXCHANGE}
            request.reply(encode(Proof.model_validate({**parts, "boot": "b00t", "now": now})))

    key = node_command(NAMESPACE, "maze", "challenge")
    async with session.answering(key, Bound(10, lose="newest"), b"") as requests, background() as tasks:
        tasks.start_soon(prove_all)
        yield


async def test_a_token_keeps_no_node_with_keys_from_starting(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only one who proves that it has keys of the name does, and is not revoked."""
    monkeypatch.setattr("seoro.bridges.naming.PATIENCE", 0.05)
    lab, endpoint = make_lab(tmp_path / "lab"), f"unixsock-stream/{tmp_path}/hub"
    keys = read_keys(lab.keys("maze"))
    door = Door(None, endpoint, keys, Revoked(keys), "maze")

    async def start() -> None:
        async with background() as tasks:
            await tasks.start(door.attend, served)

    async with open_session(listen=endpoint) as hub, hub.token(node_token(NAMESPACE, "maze", "0")):
        await start()
        for name in ("ada", "hub"):
            async with proving(hub, read_keys(lab.keys(name))):
                await start()
        async with proving(hub, keys):
            with pytest.raises(InvalidUse, match="there is a node 'maze' at"):
                await start()
            lab.revoke("maze")
            lab.authority.add("maze", Role.NODE, tmp_path / "again")
            again = read_keys(tmp_path / "again")
            door = replace(door, keys=again, revoked=Revoked(again))
            await start()  # by a new key, since the other was lost and is revoked
