"""Announcement of ROS 2 nodes that were started before their router.

A peer of Zenoh 1.8 or older announces its endpoints to a router in the answer to a query. Routers of Zenoh 1.9 and
newer, like seoro's, ignore such answers: messages and requests arrive, but clients do not see the node. This
happens after a restart of the router, or when the node was started first. So the router inspects each peer of this
machine, and announces the missing endpoints while the peer is connected. It does so as another peer: a node passes
on the announcements of its router, so announcements by the router itself would never end.
"""

from __future__ import annotations

import json
import logging
from typing import Final

import anyio

from seoro.bridges.session import AsyncSession, SessionError, is_local, open_session

PERIOD: Final = 0.5  # [s] between two checks of the connected peers
CHECKS: Final = 2  # number of checks before a peer is inspected; by then it has announced itself if it can
ANSWER_TIMEOUT: Final = 3.0  # [s]

log = logging.getLogger(__name__)


async def announce_silent_peers(router: AsyncSession) -> None:
    """Announce the nodes of connected peers that cannot announce themselves, without end.

    Args:
        router: Session of the router.
    """
    checks: dict[str, int] = {}
    inspected: dict[str, anyio.CancelScope] = {}
    async with anyio.create_task_group() as tasks:
        while True:
            peers = router.blocking.peers()
            for peer in inspected.keys() - peers:
                inspected.pop(peer).cancel()
            checks = {peer: checks.get(peer, 0) + 1 for peer in peers - inspected.keys()}
            for peer in [peer for peer, count in checks.items() if count == CHECKS]:
                inspected[peer] = anyio.CancelScope()
                tasks.start_soon(_announce_peer, router, peer, inspected[peer])
            await anyio.sleep(PERIOD)


async def _announce_peer(router: AsyncSession, peer: str, scope: anyio.CancelScope) -> None:
    """Announce the liveliness tokens of a peer if the router lacks some of them."""
    with scope:
        tokens = f"@ros2_lv/*/{peer}/**"
        try:
            for endpoint in await _endpoints(router, peer):
                async with open_session(connect=endpoint, as_peer=True) as near:
                    own = await near.list_tokens(tokens, ANSWER_TIMEOUT)
                    if own - await router.list_tokens(tokens, ANSWER_TIMEOUT):
                        await _announce(router, near, tokens)
                    return
            if await router.list_tokens(tokens, ANSWER_TIMEOUT):
                return
            reason = "it does not listen on this machine"
        except SessionError as error:
            reason = str(error)
        log.warning(
            "the peer %s announces no ROS 2 nodes, and cannot be inspected: %s. If its nodes are missing, restart "
            "them: a router of Zenoh 1.9 or newer does not see nodes of 1.8 that were started before it",
            peer,
            reason,
        )


async def _endpoints(router: AsyncSession, peer: str) -> list[str]:
    """Return the endpoints of this machine at which a peer listens, from its administration space."""
    answer = await router.query(f"@/{peer}/peer", b"", ANSWER_TIMEOUT)
    try:
        found = json.loads(answer)["locators"]
        return [each for each in found if isinstance(each, str) and is_local(each)]
    except (ValueError, KeyError, TypeError):
        return []


async def _announce(router: AsyncSession, near: AsyncSession, tokens: str) -> None:
    """Announce the liveliness tokens of a peer at a router, without end."""
    announced: dict[str, anyio.CancelScope] = {}
    async with near.tokens(tokens) as changes, anyio.create_task_group() as tasks:
        async for token, is_alive in changes:
            if is_alive and token not in announced:
                announced[token] = anyio.CancelScope()
                tasks.start_soon(_announce_token, router, token, announced[token])
            elif not is_alive and token in announced:
                announced.pop(token).cancel()


async def _announce_token(router: AsyncSession, token: str, scope: anyio.CancelScope) -> None:
    with scope:
        async with router.token(token):
            await anyio.sleep_forever()
