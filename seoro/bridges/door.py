"""Where something is reached: a session, opened anew when somebody's keys are revoked.

Zenoh has the list of those whom it lets pass when a session opens, and keeps it. So a hub is closed and opened for
each new list: sessions of others come back by themselves, but those that are on it get nothing any more. What was
asked for meanwhile has to be asked for again.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import anyio
from anyio.abc import TaskStatus

from seoro.background import background
from seoro.bridges.naming import becomes_free, is_proven
from seoro.bridges.revoked import Revoked
from seoro.bridges.secured import SERVING_NODES, node_keys, security_of
from seoro.bridges.session import AsyncSession, SessionError, is_secured, open_session
from seoro.bridges.wire.keys import NAMESPACE, node_command, node_tokens_of
from seoro.bridges.wire.limits import MAX_REQUEST
from seoro.bridges.wire.proving import CHALLENGE
from seoro.errors import InvalidUse

if TYPE_CHECKING:
    from seoro.keys.folder import Keys
    from seoro.keys.revocation import Revocations

LARGEST_RECEIVED: Final = MAX_REQUEST + (1 << 16)  # [bytes] of a message with what Zenoh adds to it
PAUSE: Final = 0.2  # [s] before an endpoint that does not open again is tried once more

log = logging.getLogger(__name__)

Served = Callable[[AsyncSession], AbstractAsyncContextManager[object]]
"""Serves at a session for as long as a block lasts."""


@dataclass(frozen=True)
class Door:
    """Where something is reached; exactly one of `listen` and `connect` is given.

    Args:
        listen: Endpoint at which it listens, as the hub of others.
        connect: Endpoint of a hub to connect to, instead.
        keys: Its keys, if it has any.
        revoked: Who is revoked, if it has keys.
        node: Name of the node that is reached there, which no other may have when it comes; None for no node.
        namespace: Of that.
        gossip: Whether peers that connect to this hub learn of each other, such as nodes of ROS 2 (see `Session`).
        largest: [bytes] of a message that is received.
    """

    listen: str | None = None
    connect: str | None = None
    keys: Keys | None = None
    revoked: Revoked | None = None
    node: str | None = None
    namespace: str = NAMESPACE
    gossip: bool = False
    largest: int = LARGEST_RECEIVED

    async def attend(self, serve: Served, *, task_status: TaskStatus[None]) -> None:
        """Serve, at one session after another; does not end. It has started when the first one is served.

        Raises:
            InvalidUse: There is another node of the name.
            SessionError: The endpoint does not work. If it did before, it is tried again and again instead.
        """
        async with background() as duties:
            if self.revoked is not None:
                duties.start_soon(self.revoked.follow)
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
                    log.error("cannot be reached: %s; trying again", error)
                    await anyio.sleep(PAUSE)

    def open(self, known: Revocations | None) -> AbstractAsyncContextManager[AsyncSession]:
        """Open a session there.

        Args:
            known: Identities that are revoked, which get nothing from one that listens; None without keys.
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
        """Check that runs which ask for the node by its name reach no other."""
        if self.node is None or await becomes_free(session, node_tokens_of(self.namespace, self.node)):
            return
        key = node_command(self.namespace, self.node, CHALLENGE.name)
        if self.keys is not None and not await is_proven(session, key, self.keys):
            log.warning(
                "ignoring a liveliness token of the name '%s': nobody proves that it has the keys of that name",
                self.node,
            )
            return
        raise InvalidUse(
            f"there is a node '{self.node}' at {self.listen or self.connect} already",
            help="end it, or give one of them another name: `--name` of a bridge, `--node` of a simulator",
        )

    async def _until_closed(self, known: Revocations | None) -> None:
        """Wait until the session has to be opened anew; one that is no hub lets nobody pass by itself."""
        if self.revoked is None or known is None or self.listen is None or not is_secured(self.listen):
            await anyio.sleep_forever()
        else:
            await self.revoked.wait_for_change(known)


def node_door(listen: str | None, connect: str | None, name: str, namespace: str = NAMESPACE) -> Door:
    """Where a node of a name is reached, with its keys where it needs some.

    Raises:
        InvalidUse: They are missing, or of no use there.
    """
    keys = node_keys(listen or connect or "", SERVING_NODES)
    if keys is not None and keys.identity.name != name:
        raise InvalidUse(
            f"the node '{name}' cannot have the keys of {keys.identity}",
            help="runs trust a node whose keys have its name: leave the name out",
        )
    return Door(listen, connect, keys, None if keys is None else Revoked(keys), name, namespace)


def node_name(endpoint: str, chosen: str | None, otherwise: str) -> str:
    """The name of a node: what was chosen, else that in its keys, else another."""
    if chosen is not None:
        return chosen
    keys = node_keys(endpoint, SERVING_NODES)
    return otherwise if keys is None else keys.identity.name
