"""ROS 2 nodes reach each other through a router of seoro."""

from __future__ import annotations

import os
import threading
from contextlib import AsyncExitStack
from pathlib import Path

import anyio
import pytest
import zenoh
from anyio.abc import TaskStatus
from zenoh.handlers import Callback

from seoro.bridges.ros2.expose.running import ExposeSettings, expose
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.routing import run_router
from seoro.bridges.session import Session, open_session
from seoro.concurrency.background import background
from seoro.security.network.listener import Listener
from tests.bridges.ros2.peers import peer
from tests.bridges.ros2.systems import STRING, two_nodes
from tests.labs import command, free_port, make_lab
from tests.routers import free_endpoint

DEADLINE = 30.0  # [s]


def reach_each_other(router: str) -> bool:
    """Return whether messages and tokens of one peer reach another."""
    seen, matched, arrived = threading.Event(), threading.Event(), threading.Event()
    with peer(router) as talker, peer(router) as listener:

        def see(_: zenoh.Sample) -> None:
            seen.set()

        def take(_: zenoh.Sample) -> None:
            arrived.set()

        def note(status: zenoh.MatchingStatus) -> None:
            if status.matching:
                matched.set()

        token = talker.liveliness().declare_token("@ros2_lv/0/talker")
        publisher = talker.declare_publisher("0/chatter")
        matching = publisher.declare_matching_listener(Callback(note, indirect=False))
        watcher = listener.liveliness().declare_subscriber(
            "@ros2_lv/**", Callback(see, indirect=False), history=True
        )
        subscriber = listener.declare_subscriber("0/chatter", Callback(take, indirect=False))
        kept = (token, matching, watcher, subscriber)
        if not (seen.wait(DEADLINE) and matched.wait(DEADLINE)):
            return False
        publisher.put(b"hello")
        is_reached = arrived.wait(DEADLINE)
        del kept
        return is_reached


def is_announced(router: str) -> bool:
    """Return whether a client receives the token of a node that does not announce itself to the router.

    The router misses tokens that arrive after its query, as on a busy machine; therefore, several attempts.
    """
    seen = threading.Event()

    def see(_: str, alive: bool) -> None:
        if alive:
            seen.set()

    client = Session(connect=router)
    try:
        client.watch_tokens("@ros2_lv/0/*/silent", see)
        [identity] = client.handle.info.routers_zid()
        for _ in range(5):
            with peer(router, silent_to=str(identity)) as node:
                token = node.liveliness().declare_token(f"@ros2_lv/0/{node.zid()}/silent")
                if seen.wait(DEADLINE / 5):
                    return True
                del token
        return False
    finally:
        client.close()


def test_nodes_at_a_router_of_the_command_line_reach_each_other(tmp_path: Path) -> None:
    endpoint = free_endpoint()
    with command(tmp_path / "log", endpoint, "router", "--listen", endpoint):
        assert reach_each_other(endpoint)
        assert is_announced(endpoint)


async def test_nodes_at_a_bridge_that_exposes_and_listens_reach_each_other(simulator: str) -> None:
    endpoint = free_endpoint()
    async with background() as tasks:
        ready = anyio.Event()
        tasks.start_soon(expose, ExposeSettings(simulator, None, endpoint), lambda _: ready.set())
        with anyio.fail_after(DEADLINE):
            await ready.wait()
        assert await anyio.to_thread.run_sync(reach_each_other, endpoint)
        assert await anyio.to_thread.run_sync(is_announced, endpoint)


@pytest.mark.parametrize("scheme", ["tcp", "tls"])
async def test_routers_with_keys_do_not_gossip(
    scheme: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lab, listeners = make_lab(tmp_path), list[Listener]()

    async def serve(self: Listener, _serve: object, *, task_status: TaskStatus[None]) -> None:
        listeners.append(self)
        task_status.started()

    monkeypatch.setattr(Listener, "serve", serve)
    keys = lab.keys("hub") if scheme == "tls" else None
    async with background() as tasks:
        ready = anyio.Event()
        tasks.start_soon(run_router, f"{scheme}/127.0.0.1:{free_port()}", keys, ready.set)
        await ready.wait()
    assert [listener.gossip for listener in listeners] == [scheme == "tcp"]


async def test_nodes_of_one_machine_are_connected_directly(types: TypeStore) -> None:
    """Their messages arrive without the router, and they listen on this machine only."""
    endpoint = free_endpoint()
    async with AsyncExitStack() as router:
        await router.enter_async_context(open_session(listen=endpoint, gossip=True))
        async with (
            two_nodes(endpoint, types) as (there, here),
            there.publishing("/chatter", STRING) as publication,
            here.subscribing("/chatter", STRING) as subscription,
        ):
            await publication.wait_for_subscription(DEADLINE)
            with anyio.fail_after(DEADLINE):
                while there.system.session.identity not in here.system.session.blocking.peers():
                    await anyio.sleep(0.01)
            await router.aclose()
            publication.publish({"data": "directly"})
            with anyio.fail_after(DEADLINE):
                assert (await subscription.message()).data == "directly"
            assert listening_addresses() == {"127.0.0.1"}


def listening_addresses() -> set[str]:
    """Return the addresses at which this process listens by TCP over IPv4 or IPv6."""
    own = {os.fspath(each.readlink()) for each in Path("/proc/self/fd").iterdir() if each.is_symlink()}
    found = set()
    for table in ("tcp", "tcp6"):
        for line in Path(f"/proc/self/net/{table}").read_text().splitlines()[1:]:
            _, local, _, state, *_, inode = line.split()[:10]
            if state == "0A" and f"socket:[{inode}]" in own:
                digits = bytes.fromhex(local.partition(":")[0])
                found.add(".".join(map(str, reversed(digits))) if table == "tcp" else digits.hex())
    return found
