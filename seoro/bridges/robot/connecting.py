"""Getting at robots behind a bridge, or in a simulator that plays by itself, and holding them."""

from __future__ import annotations

import secrets
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import anyio

from seoro.background import background
from seoro.bridges import wire
from seoro.bridges.finding import find_node
from seoro.bridges.robot.node import RobotNode
from seoro.bridges.seals import node_seals
from seoro.bridges.secured import check_reached, node_keys, security_of
from seoro.bridges.session import AsyncSession, InvalidEndpoint, Security, SessionError, open_session
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.errors import BackendError, BackendRefused, BackendUnreachable, InvalidUse
from seoro.keys.roles import MOVING

if TYPE_CHECKING:
    from seoro.keys.folder import Keys

RELEASE_TIMEOUT = 5.0  # [s]
START = "start one with `seoro bridge ros2`"


class NoSuchRobot(InvalidUse):
    """There is no robot of a name; the message says which, and which there are."""


class RobotsTaken(BackendUnreachable):
    """Another client holds the robots; a later attempt may succeed."""


def _any_name() -> str:
    return f"run-{secrets.token_hex(8)}"


@dataclass(frozen=True)
class Claim:
    """By what robots are claimed.

    Args:
        holder: Name of the client, which no other has; it has one place in line everywhere.
        lease: Id of a lease by hand under which it has them.
        waits: Whether it comes back soon when it does not get them.
        priority: Of its place in line.
    """

    holder: str = field(default_factory=_any_name)
    lease: str = ""
    waits: bool = False
    priority: int = 0

    def of(self, purpose: str, robots: tuple[str, ...] = (), *, gives_signs: bool = True) -> wire.Holder:
        """The request for robots; for all that a node has if none are named."""
        return wire.Holder(
            holder=self.holder,
            purpose=purpose,
            robots=robots,
            lease=self.lease,
            waits=self.waits,
            priority=self.priority,
            gives_signs=gives_signs,
        )


@asynccontextmanager
async def connect_robots(
    endpoint: str,
    purpose: str,
    name: str | None = None,
    robots: tuple[str, ...] = (),
    claim: Claim | None = None,
) -> AsyncIterator[RobotNode]:
    """Hold robots for as long as the block lasts; they stand still when it ends.

    Args:
        endpoint: Zenoh endpoint of the bridge, or of the router that it is connected to.
        purpose: What they are held for, for others who want them.
        name: Of the bridge; None for the only one there.
        robots: Which robots; all of the bridge if none are named.
        claim: By what they are claimed.

    Raises:
        RobotsTaken: Others have them.
        NoSuchRobot: There is none of a name.
        BackendUnreachable: There is no bridge (yet).
        InvalidUse: They cannot be had.
    """
    keys = node_keys(endpoint, MOVING)
    security = security_of(endpoint, keys)
    holder = (claim or Claim()).of(purpose, robots)
    try:
        async with (
            open_session(connect=endpoint, security=security) as session,
            _held(session, endpoint, holder, name, keys) as node,
        ):
            yield node
    except SessionError as error:
        raise not_reached(endpoint, security, error, START) from error


def not_reached(endpoint: str, security: Security | None, error: SessionError, start: str) -> Exception:
    """Exception for a session that cannot be opened.

    Args:
        endpoint: Where.
        security: Of the session.
        error: Why, as the session says.
        start: How a node is started there.

    Raises:
        InvalidUse: The keys here do not fit those of the endpoint.
    """
    if isinstance(error, InvalidEndpoint):
        return InvalidUse(str(error), help=start)
    check_reached(endpoint, security)
    return BackendUnreachable(str(error), help=start)


@asynccontextmanager
async def _held(
    session: AsyncSession, endpoint: str, holder: wire.Holder, name: str | None, keys: Keys | None
) -> AsyncIterator[RobotNode]:
    found = await find_node(session, endpoint, name, "bridge to robots", START)
    address = NodeAddress(
        session, wire.NAMESPACE, found, "bridge", holder.holder, node_seals(session, found, keys)
    )
    await address.prove()
    async with held(address, holder) as features:
        node = RobotNode(address, holder, features)
        async with background() as group:
            group.start_soon(node.hold)
            yield node


@asynccontextmanager
async def held(address: NodeAddress, holder: wire.Holder) -> AsyncIterator[wire.RobotFeatures]:
    """Hold robots of a node for as long as the block lasts, in which its client gives signs of life if it said so.

    Raises:
        RobotsTaken: Others have them.
        InvalidUse: They cannot be had.
    """
    async with address.session.token(wire.holder_token(wire.NAMESPACE, holder.holder)):
        features = await _take(address, holder)
        try:
            yield features
        except RobotsTaken:
            await _release(address, holder)
            raise
        except BaseException:
            await _release(address, holder.model_copy(update={"waits": False}))
            raise
        await _release(address, holder.model_copy(update={"waits": False}))


async def _release(address: NodeAddress, holder: wire.Holder) -> None:
    with anyio.move_on_after(RELEASE_TIMEOUT, shield=True), suppress(BackendError):
        await ask(address, wire.RELEASE_ROBOTS, holder, RELEASE_TIMEOUT)


async def _take(address: NodeAddress, holder: wire.Holder) -> wire.RobotFeatures:
    asked = holder if address.seals is None else address.seals.identify(holder)
    try:
        return await ask(address, wire.TAKE_ROBOTS, asked)
    except BackendRefused as refused:
        if refused.code == wire.Result.FEATURE_UNSUPPORTED:
            raise InvalidUse(f"'{address.node}' is a simulator, not a bridge to robots", help=START) from refused
        if refused.code == wire.Result.NOT_FOUND:
            raise NoSuchRobot(str(refused)) from refused
        kind = RobotsTaken if refused.code == wire.LabResult.HELD else InvalidUse
        what = "the simulator" if not holder.gives_signs else "the robots of the bridge"
        raise kind(f"{what} '{address.node}' cannot be had: {refused}") from refused
