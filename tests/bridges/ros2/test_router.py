"""Nodes of ROS 2 reach each other where seoro is their router."""

from __future__ import annotations

import threading
from pathlib import Path

import anyio
import pytest
import zenoh
from anyio.abc import TaskStatus
from zenoh.handlers import Callback

from seoro.background import background
from seoro.bridges.door import Door
from seoro.bridges.ros2.expose.running import ExposeSettings, expose
from seoro.bridges.routing import route
from seoro.bridges.session import Session, SessionError, open_session
from tests.bridges.ros2.peers import peer
from tests.labs import command, free_port, make_lab
from tests.routers import free_endpoint

DEADLINE = 30.0  # [s]


def reach_each_other(router: str) -> bool:
    """Whether what one peer publishes and announces reaches another."""
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
    """Whether a client sees a node that its router does not see by itself.

    A token that comes after the router has looked is withheld for ever, as busy machines may have it: there are
    more attempts.
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
async def test_routers_with_keys_tell_nobody_the_addresses_of_others(
    scheme: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lab, doors = make_lab(tmp_path), list[Door]()

    async def attend(self: Door, _serve: object, *, task_status: TaskStatus[None]) -> None:
        doors.append(self)
        task_status.started()

    monkeypatch.setattr(Door, "attend", attend)
    keys = lab.keys("hub") if scheme == "tls" else None
    async with background() as tasks:
        ready = anyio.Event()
        tasks.start_soon(route, f"{scheme}/127.0.0.1:{free_port()}", keys, ready.set)
        await ready.wait()
    assert [door.gossip for door in doors] == [scheme == "tcp"]


async def test_gossip_is_what_routers_do() -> None:
    with pytest.raises(SessionError, match="gossip needs a router"):
        async with open_session(connect=free_endpoint(), gossip=True):
            pass
