"""Connections to robots of bridges and of playing simulators, and holds of these robots."""

from __future__ import annotations

import secrets
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, field

import anyio

from seoro.bridges import wire
from seoro.bridges.finding import find_node
from seoro.bridges.robot.node import RobotNode
from seoro.bridges.session import InvalidEndpoint, Security, SessionError, open_session
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.concurrency.background import background
from seoro.errors import BackendError, BackendRefused, BackendUnreachable, UsageError
from seoro.security.keys.roles import MOVING
from seoro.security.network.endpoint_keys import check_reached, node_keys, security_of
from seoro.security.network.peers import node_signer

RELEASE_TIMEOUT = 5.0  # [s]
START = "start one with `seoro bridge ros2`"


class UnknownRobot(UsageError):
    """The robot is unknown; the message lists the robots of the node."""


class RobotsBusy(BackendUnreachable):
    """Another client holds the robots; a later attempt may succeed."""


@dataclass(frozen=True)
class Claim:
    """Claim of robots by a run.

    Args:
        holder: Unique name of the client, for one place in all wait queues.
        lease: Id of a manual lease of the robots.
        waits: Whether the client retries soon if the robots are busy.
        priority: Priority in the wait queues.
    """

    holder: str = field(default_factory=lambda: f"run-{secrets.token_hex(8)}")
    lease: str = ""
    waits: bool = False
    priority: int = 0

    def request(self, purpose: str, robots: tuple[str, ...] = (), *, sends_heartbeats: bool = True) -> wire.Holder:
        """Return the request for robots, or for a whole node if none are named."""
        return wire.Holder(
            holder=self.holder,
            purpose=purpose,
            robots=robots,
            lease=self.lease,
            waits=self.waits,
            priority=self.priority,
            gives_signs=sends_heartbeats,
        )


@asynccontextmanager
async def connect_robots(
    endpoint: str, purpose: str, name: str | None = None, robots: tuple[str, ...] = (), claim: Claim | None = None
) -> AsyncIterator[RobotNode]:
    """Hold robots while the block lasts; they are stopped at its end.

    Args:
        endpoint: Zenoh endpoint of the bridge, or of its router.
        purpose: Purpose of the hold, shown to other clients.
        name: Name of the bridge; None for the only one.
        robots: Names of robots; all of the bridge if empty.
        claim: Claim of the robots.

    Raises:
        RobotsBusy: Another client holds the robots.
        UnknownRobot: A robot is unknown.
        BackendUnreachable: No bridge was found (yet).
        UsageError: The node is a simulator, or refuses the claim.
    """
    keys = node_keys(endpoint, MOVING)
    security = security_of(endpoint, keys)
    holder = (claim or Claim()).request(purpose, robots)
    try:
        async with open_session(connect=endpoint, security=security) as session:
            found = await find_node(session, endpoint, name, "bridge to robots", START)
            signer = node_signer(session, found, keys)
            address = NodeAddress(session, wire.NAMESPACE, found, "bridge", holder.holder, signer)
            await address.prove()
            async with held(address, holder) as features, background() as group:
                node = RobotNode(address, holder, features)
                group.start_soon(node.send_heartbeats)
                group.start_soon(node.tracks.run)
                yield node
    except SessionError as error:
        raise connection_error(endpoint, security, error, START) from error


def connection_error(endpoint: str, security: Security | None, error: SessionError, start: str) -> Exception:
    """Return the exception for a failed session.

    Args:
        endpoint: Endpoint of the session.
        security: Keys of the session.
        error: Error of the session.
        start: Command that starts a node there.

    Raises:
        UsageError: The endpoint rejects the keys.
    """
    if isinstance(error, InvalidEndpoint):
        return UsageError(str(error), help=start)
    check_reached(endpoint, security)
    return BackendUnreachable(str(error), help=start)


@asynccontextmanager
async def held(address: NodeAddress, holder: wire.Holder) -> AsyncIterator[wire.RobotFeatures]:
    """Hold robots of a node while the block lasts, in which the client sends the announced heartbeats.

    Raises:
        RobotsBusy: Another client holds the robots.
        UsageError: The node refuses the claim.
    """
    async with address.session.token(wire.holder_token(wire.NAMESPACE, holder.holder)):
        features = await _acquire(address, holder)
        waits = False
        try:
            yield features
        except RobotsBusy:  # other robots are busy: keep the place in the queue
            waits = holder.waits
            raise
        finally:
            with anyio.move_on_after(RELEASE_TIMEOUT, shield=True), suppress(BackendError):
                released = holder.model_copy(update={"waits": waits})
                await ask(address, wire.RELEASE_ROBOTS, released, RELEASE_TIMEOUT)


async def _acquire(address: NodeAddress, holder: wire.Holder) -> wire.RobotFeatures:
    request = holder if address.signer is None else address.signer.add_holder_key(holder)
    try:
        return await ask(address, wire.TAKE_ROBOTS, request)
    except BackendRefused as refused:
        if refused.code == wire.Result.FEATURE_UNSUPPORTED:
            raise UsageError(f"'{address.node}' is a simulator, not a bridge to robots", help=START) from refused
        if refused.code == wire.Result.NOT_FOUND:
            raise UnknownRobot(str(refused)) from refused
        kind = RobotsBusy if refused.code == wire.LabResult.HELD else UsageError
        what = "robots of the bridge" if holder.gives_signs else "simulator"
        raise kind(f"cannot acquire the {what} '{address.node}': {refused}") from refused
