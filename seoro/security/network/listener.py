"""Listener of a server: its session, which is reopened when keys are revoked.

Zenoh reads its access control when a session opens, and keeps it. So the session of a hub is closed and opened
again for each new list of revoked keys. Sessions with valid keys reconnect by themselves; requests in between have
to be repeated.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from typing import TYPE_CHECKING, Final

import anyio
from anyio.abc import TaskStatus

from seoro.bridges.naming import is_proven, wait_until_free
from seoro.bridges.session import AsyncSession, SessionError, is_secured, open_session
from seoro.bridges.wire.authentication import CHALLENGE
from seoro.bridges.wire.keys import NAMESPACE, node_command, node_tokens_of
from seoro.bridges.wire.limits import MAX_REQUEST
from seoro.concurrency.background import background
from seoro.deferred import dataclass
from seoro.errors import UsageError
from seoro.security.network.endpoint_keys import SERVING_NODES, node_keys, security_of
from seoro.security.network.revocation_monitor import RevocationMonitor

if TYPE_CHECKING:
    from seoro.security.keys.folder import Keys
    from seoro.security.keys.revocation import Revocations

LARGEST_RECEIVED: Final = MAX_REQUEST + (1 << 16)  # [bytes] of a message with Zenoh's headers
PAUSE: Final = 0.2  # [s] between attempts to reopen an endpoint

log = logging.getLogger(__name__)

Served = Callable[[AsyncSession], AbstractAsyncContextManager[object]]
"""Serves at a session while a block lasts."""


@dataclass(frozen=True)
class Listener:
    """Endpoint of a server; exactly one of `listen` and `connect` is given.

    Args:
        listen: Endpoint to listen at, as the hub of others.
        connect: Endpoint of a hub to connect to.
        keys: Keys of the server; None without keys.
        revoked: Monitor of revoked keys; None without keys.
        node: Name of the node, which must be free at the start; None for servers that are not nodes.
        namespace: Namespace of the node.
        gossip: Whether peers of this hub discover each other, such as nodes of ROS 2 (see `Session`).
        largest: Size limit of received messages [bytes].
    """

    listen: str | None = None
    connect: str | None = None
    keys: Keys | None = None
    revoked: RevocationMonitor | None = None
    node: str | None = None
    namespace: str = NAMESPACE
    gossip: bool = False
    largest: int = LARGEST_RECEIVED

    async def serve(self, serve: Served, *, task_status: TaskStatus[None]) -> None:
        """Serve one session after another; does not return. Reports its start once the first session is served.

        Raises:
            UsageError: Another node has the name.
            SessionError: The first session cannot be opened; later failures are retried.
        """
        async with background() as duties:
            if self.revoked is not None:
                duties.start_soon(self.revoked.watch)
            is_open = False
            while True:
                known = None if self.revoked is None else self.revoked.current()
                try:
                    async with self.open(known) as session:
                        if not is_open:
                            await self._check_name(session)
                        async with serve(session):
                            if not is_open:
                                task_status.started()
                            is_open = True
                            await self._until_closed(known)
                except SessionError as error:
                    if not is_open:
                        raise
                    log.error("cannot reopen the session: %s; trying again", error)
                    await anyio.sleep(PAUSE)

    def open(self, known: Revocations | None) -> AbstractAsyncContextManager[AsyncSession]:
        """Open a session at the endpoint.

        Args:
            known: Revoked keys, which a hub rejects; None without keys.
        """
        endpoint = self.listen or self.connect or ""
        security = security_of(endpoint, self.keys, listens=self.listen is not None, revoked=known)
        return open_session(
            listen=self.listen,
            connect=self.connect,
            security=security,
            gossip=self.gossip,
            largest=self.largest,
        )

    async def _check_name(self, session: AsyncSession) -> None:
        """Check that the name of the node is free."""
        if self.node is None or await wait_until_free(session, node_tokens_of(self.namespace, self.node)):
            return
        key = node_command(self.namespace, self.node, CHALLENGE.name)
        if self.keys is not None and not await is_proven(session, key, self.keys):
            log.warning(
                "ignoring a liveliness token of the name '%s': its owner does not prove that it has the keys",
                self.node,
            )
            return
        raise UsageError(
            f"duplicate node '{self.node}' at {self.listen or self.connect}",
            help="stop the other node, or choose another name: `--name` of a bridge, `--node` of a simulator",
        )

    async def _until_closed(self, known: Revocations | None) -> None:
        """Wait until the session has to be reopened; only hubs with keys do that."""
        if self.revoked is None or known is None or self.listen is None or not is_secured(self.listen):
            await anyio.sleep_forever()
        else:
            await self.revoked.wait_for_change(known)


def node_listener(listen: str | None, connect: str | None, name: str, namespace: str = NAMESPACE) -> Listener:
    """Return the listener of a node, with the keys that the endpoint needs.

    Raises:
        UsageError: The keys are missing, or not those of the node.
    """
    keys = node_keys(listen or connect or "", SERVING_NODES)
    if keys is not None and keys.identity.name != name:
        raise UsageError(
            f"the keys of {keys.identity} do not fit the node '{name}'",
            help="leave out the name: a node has the name in its keys",
        )
    return Listener(listen, connect, keys, None if keys is None else RevocationMonitor(keys), name, namespace)


def node_name(endpoint: str, chosen: str | None, otherwise: str) -> str:
    """Return the name of a node: `chosen`, else the name in its keys, else `otherwise`."""
    if chosen is not None:
        return chosen
    keys = node_keys(endpoint, SERVING_NODES)
    return otherwise if keys is None else keys.identity.name
