"""Nodes of ROS 2 that were there before their router: a router announces them, since they cannot.

A peer of Zenoh 1.8 or older that reaches a router announces what it has as an answer to a question, and routers of
Zenoh 1.9 and newer, as seoro's is, ignore such answers. What a node publishes and serves arrives, but clients do
not see the node: after a restart of the router, or when the node was started first. So the router looks at each
peer of this machine itself, and announces in its place what is missing, for as long as the peer is connected. It
does so as another peer: what a client of a node learns includes what the node has from the router, so that nothing
would end that the router announces.
"""

from __future__ import annotations

import json
import logging
from typing import Final

import anyio
from anyio.abc import TaskGroup

from seoro.bridges.session import AsyncSession, SessionError, is_local, open_session

PERIOD: Final = 0.5  # [s] between two looks at who is connected
LOOKS: Final = 2  # after which a peer has had the time to announce itself
ANSWER_WITHIN: Final = 3.0  # [s]

log = logging.getLogger(__name__)


async def announce_silent_peers(router: AsyncSession) -> None:
    """Announce the nodes of peers that have connected to a router and do not do it themselves; does not end.

    Args:
        router: The session that is the router.
    """
    looks: dict[str, int] = {}
    seen_to: dict[str, anyio.CancelScope] = {}
    async with anyio.create_task_group() as tasks:
        while True:
            peers = router.blocking.peers()
            for peer in seen_to.keys() - peers:
                seen_to.pop(peer).cancel()
            looks = {peer: looks.get(peer, 0) + 1 for peer in peers - seen_to.keys()}
            for peer in [peer for peer, count in looks.items() if count == LOOKS]:
                seen_to[peer] = anyio.CancelScope()
                tasks.start_soon(_see_to, router, peer, seen_to[peer])
            await anyio.sleep(PERIOD)


async def _see_to(router: AsyncSession, peer: str, scope: anyio.CancelScope) -> None:
    """Compare what a peer has with what the router knows of it, and announce what is missing."""
    with scope:
        tokens = f"@ros2_lv/*/{peer}/**"
        try:
            for endpoint in await _endpoints(router, peer):
                async with open_session(connect=endpoint, as_peer=True) as near:
                    has = await near.list_tokens(tokens, ANSWER_WITHIN)
                    if has - await router.list_tokens(tokens, ANSWER_WITHIN):
                        await _announce(router, near, tokens)
                    return
            if await router.list_tokens(tokens, ANSWER_WITHIN):
                return
            why = "it listens at no address of this machine"
        except SessionError as error:
            why = str(error)
        log.warning(
            "the peer %s announces no ROS 2 node, and cannot be asked for any: %s. If its nodes are missing, "
            "restart them: a router of Zenoh 1.9 or newer does not see nodes of 1.8 that were started before it",
            peer,
            why,
        )


async def _endpoints(router: AsyncSession, peer: str) -> list[str]:
    """Endpoints of this machine at which a peer listens, as its administration space reports them."""
    answer = await router.query(f"@/{peer}/peer", b"", ANSWER_WITHIN)
    try:
        found = json.loads(answer)["locators"]
        return [each for each in found if isinstance(each, str) and is_local(each)]
    except (ValueError, KeyError, TypeError):
        return []


async def _announce(router: AsyncSession, near: AsyncSession, tokens: str) -> None:
    """Announce at a router what a peer announces to its peers; does not end."""
    announced: dict[str, anyio.CancelScope] = {}
    async with near.tokens(tokens) as changes, anyio.create_task_group() as tasks:
        async for token, is_alive in changes:
            if is_alive and token not in announced:
                announced[token] = _start_announcing(tasks, router, token)
            elif not is_alive and token in announced:
                announced.pop(token).cancel()


def _start_announcing(tasks: TaskGroup, router: AsyncSession, token: str) -> anyio.CancelScope:
    scope = anyio.CancelScope()

    async def announce() -> None:
        with scope:
            async with router.token(token):
                await anyio.sleep_forever()

    tasks.start_soon(announce)
    return scope
