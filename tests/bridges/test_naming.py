"""Names of nodes are unique, so that requests reach one node."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import replace
from pathlib import Path

import anyio
import pytest

from seoro.bridges.session import AsyncSession, Bound, open_session
from seoro.bridges.wire.authentication import Challenge, Proof
from seoro.bridges.wire.keys import NAMESPACE, node_command, node_token
from seoro.bridges.wire.message import decode, encode
from seoro.concurrency.background import background
from seoro.concurrency.steady_clock import steady_ns
from seoro.errors import UsageError
from seoro.security.keys.folder import Keys, read_keys
from seoro.security.keys.roles import Role
from seoro.security.network.listener import Listener, node_listener
from seoro.security.network.revocation_monitor import RevocationMonitor
from seoro.security.signing.commands import prove
from seoro.security.signing.statements import certificate_der
from tests.labs import make_lab

pytestmark = pytest.mark.anyio
EXCHANGE = b"1" * 32


@asynccontextmanager
async def served(_session: AsyncSession) -> AsyncIterator[None]:
    yield


async def come(endpoint: str, name: str, namespace: str = NAMESPACE) -> None:
    """Start and stop a node."""
    async with background() as tasks:
        await tasks.start(node_listener(None, endpoint, name, namespace).serve, served)


async def test_the_name_of_a_running_node_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/hub"
    async with open_session(listen=endpoint) as hub, hub.token(node_token(NAMESPACE, "floor", "1")):
        monkeypatch.setattr("seoro.bridges.naming.PATIENCE", 0.05)
        with pytest.raises(UsageError, match=r"duplicate node 'floor' at unixsock-stream/.*/hub"):
            await come(endpoint, "floor")
        await come(endpoint, "hall")
        await come(endpoint, "floor", "elsewhere")


async def test_a_name_is_acquired_once_its_node_has_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.bridges.naming.PATIENCE", 30.0)
    endpoint = f"unixsock-stream/{tmp_path}/hub"
    async with open_session(listen=endpoint) as hub, AsyncExitStack() as first:
        await first.enter_async_context(hub.token(node_token(NAMESPACE, "floor", "1")))
        came = anyio.Event()

        async def come_second() -> None:
            await come(endpoint, "floor")
            came.set()

        async with anyio.create_task_group() as tasks:
            tasks.start_soon(come_second)
            await anyio.sleep(0.05)
            assert not came.is_set()
            await first.aclose()
        assert came.is_set()


@asynccontextmanager
async def proving(session: AsyncSession, keys: Keys) -> AsyncIterator[None]:
    """Reply to challenges of the node 'maze'."""

    async def prove_all() -> None:
        async for request in requests:
            nonce, now = decode(Challenge, request.payload).nonce, steady_ns()
            signature = prove(keys, "maze", nonce, "b00t", now, EXCHANGE)
            certificate = certificate_der(keys.certificate)
            parts = {"certificate": certificate, "signature": signature, "exchange": EXCHANGE}
            request.reply(encode(Proof.model_validate({**parts, "boot": "b00t", "now": now})))

    key = node_command(NAMESPACE, "maze", "challenge")
    async with session.answering(key, Bound(10, drop="newest"), b"") as requests, background() as tasks:
        tasks.start_soon(prove_all)
        yield


async def test_a_forged_token_does_not_prevent_a_node_with_keys_from_starting(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only a node with valid keys of the name counts."""
    monkeypatch.setattr("seoro.bridges.naming.PATIENCE", 0.05)
    lab, endpoint = make_lab(tmp_path / "lab"), f"unixsock-stream/{tmp_path}/hub"
    keys = read_keys(lab.keys("maze"))
    listener = Listener(None, endpoint, keys, RevocationMonitor(keys), "maze")

    async def start() -> None:
        async with background() as tasks:
            await tasks.start(listener.serve, served)

    async with open_session(listen=endpoint) as hub, hub.token(node_token(NAMESPACE, "maze", "0")):
        await start()
        for name in ("ada", "hub"):
            async with proving(hub, read_keys(lab.keys(name))):
                await start()
        async with proving(hub, keys):
            with pytest.raises(UsageError, match="duplicate node 'maze' at"):
                await start()
            lab.revoke("maze")
            lab.authority.add("maze", Role.NODE, tmp_path / "again")
            again = read_keys(tmp_path / "again")
            listener = replace(listener, keys=again, revoked=RevocationMonitor(again))
            await start()  # by a new key, since the other was lost and is revoked
