"""Getting at robots behind a bridge that is running."""

from __future__ import annotations

import secrets
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

import anyio

from seoro.background import background
from seoro.bridges import wire
from seoro.bridges.robot.node import RobotNode
from seoro.bridges.secured import ASKING, check_reached, secured
from seoro.bridges.session import AsyncSession, SessionError, open_session
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.errors import BackendError, BackendRefused, InvalidUse

FIND_TIMEOUT = 3.0  # [s]
RELEASE_TIMEOUT = 5.0  # [s]
START = "start one with `seoro bridge ros2`"


@asynccontextmanager
async def connect_robots(endpoint: str, purpose: str, name: str | None = None) -> AsyncIterator[RobotNode]:
    """Hold the robots of a bridge for as long as the block lasts; they stand still when it ends.

    Args:
        endpoint: Zenoh endpoint of the bridge, or of the router that it is connected to.
        purpose: What they are held for, for others who want them.
        name: Of the bridge; None for the only one there.

    Raises:
        InvalidUse: There is no bridge, or another holds its robots.
    """
    security = secured(endpoint, ASKING)
    try:
        async with (
            open_session(connect=endpoint, security=security) as session,
            _held(session, endpoint, purpose, name) as node,
        ):
            yield node
    except SessionError as error:
        check_reached(endpoint, security)
        raise InvalidUse(str(error), help=START) from error


@asynccontextmanager
async def _held(session: AsyncSession, endpoint: str, purpose: str, name: str | None) -> AsyncIterator[RobotNode]:
    holder = wire.Holder(holder=f"run-{secrets.token_hex(8)}", purpose=purpose)
    address = NodeAddress(session, wire.NAMESPACE, await _find_node(session, endpoint, name), "bridge")
    async with session.token(wire.holder_token(wire.NAMESPACE, holder.holder)):
        node = RobotNode(address, holder, await _take(address, holder))
        async with background() as group:
            group.start_soon(node.hold)
            try:
                yield node
            finally:
                with anyio.move_on_after(RELEASE_TIMEOUT, shield=True), suppress(BackendError):
                    await node.ask(wire.RELEASE_ROBOTS, holder, RELEASE_TIMEOUT)


async def _take(address: NodeAddress, holder: wire.Holder) -> wire.RobotFeatures:
    try:
        return await ask(address, wire.TAKE_ROBOTS, holder)
    except BackendRefused as refused:
        if refused.code == wire.Result.FEATURE_UNSUPPORTED:
            raise InvalidUse(f"'{address.node}' is a simulator, not a bridge to robots", help=START) from refused
        raise InvalidUse(f"the robots of the bridge '{address.node}' cannot be had: {refused}") from refused


async def _find_node(session: AsyncSession, endpoint: str, name: str | None) -> str:
    with anyio.move_on_after(FIND_TIMEOUT):
        async with session.tokens(wire.node_tokens(wire.NAMESPACE)) as tokens:
            async for token, alive in tokens:
                node = wire.token_node(token)[0]
                if alive and name in (None, node):
                    return node
    which = "no bridge to robots" if name is None else f"no bridge '{name}'"
    raise InvalidUse(f"there is {which} at {endpoint}", help=START)
