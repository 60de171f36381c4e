"""Finding out how well the nodes of a lab are reached from here: who answers, as what, when, and by what clock."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING, Final

import anyio

from seoro.bridges import wire
from seoro.bridges.executor.clocks import Clock, compare
from seoro.bridges.executor.sight import Hop, NodeSeen, PlaceSeen
from seoro.bridges.seals import node_seals
from seoro.bridges.secured import ASKING, check_reached, keys_for, security_of
from seoro.bridges.session import AsyncSession, Security, SessionError, is_secured, open_session
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.errors import BackendError, InvalidUse
from seoro.keys.roles import MOVING

if TYPE_CHECKING:
    from seoro.keys.folder import Keys

EXCHANGES: Final = 100  # for the latency
SEEN_WITHIN: Final = 2.0  # [s] for tokens
LOOK_AGAIN: Final = 0.05  # [s] between two looks for nodes
ANSWER_WITHIN: Final = 2.0  # [s]


async def examine(
    endpoint: str, folder: Path | None = None, wanted: Collection[str] = (), exchanges: int = EXCHANGES
) -> PlaceSeen:
    """What is seen at an endpoint, from here.

    Args:
        endpoint: The endpoint.
        folder: Of keys, as for commands.
        wanted: Names of nodes that are waited for a little.
        exchanges: With each node.
    """
    try:
        keys = keys_for(endpoint, ASKING, folder)
        security = security_of(endpoint, keys)
    except InvalidUse as error:
        return PlaceSeen(endpoint=endpoint, ends_at=Hop.KEYS, why=str(error), advice=error.help)
    who = who_asks(endpoint, keys)
    try:
        async with open_session(connect=endpoint, security=security) as session:
            nodes = await examine_nodes(session, endpoint, keys, wanted, exchanges)
            return PlaceSeen(endpoint=endpoint, who=who, nodes=nodes)
    except SessionError as error:
        why, advice = why_unreached(endpoint, error, security)
        return PlaceSeen(endpoint=endpoint, who=who, ends_at=Hop.SESSION, why=why, advice=advice)


def who_asks(endpoint: str, keys: Keys | None) -> str:
    """Who somebody with keys is at an endpoint, by name and role; empty where keys do not count."""
    return str(keys.identity) if keys is not None and is_secured(endpoint) else ""


def why_unreached(endpoint: str, error: SessionError, security: Security | None) -> tuple[str, str]:
    """Why there is no session at an endpoint, and what to do, in words."""
    try:
        check_reached(endpoint, security)
    except InvalidUse as why:
        return str(why), why.help
    return (
        f"nothing at {endpoint} speaks Zenoh with us: {error}",
        "check that an executor, a node or a router of seoro listens there, and not another program; one that "
        "stands still (`kill -STOP`, a debugger) answers nobody",
    )


async def examine_nodes(
    session: AsyncSession,
    endpoint: str,
    keys: Keys | None,
    wanted: Collection[str] = (),
    exchanges: int = EXCHANGES,
) -> tuple[NodeSeen, ...]:
    """All nodes that a session reaches, by their names; see `examine`."""
    found = await _tokens(session, wanted)
    names = Counter(wire.token_node(token)[0] for token in found)
    majors = {wire.token_node(token)[0]: wire.token_major(token) for token in sorted(found)}
    may_use = not is_secured(endpoint) or (keys is not None and keys.identity.role in MOVING)
    own = keys if is_secured(endpoint) else None
    seen: dict[str, NodeSeen] = {}

    async def see(name: str) -> None:
        node = NodeSeen(node=name, count=names[name], major=majors[name])
        address = _address(session, node, own)
        seen[name] = await _first_look(address, node, may_use=may_use) if _is_ours(node) else node

    async with anyio.create_task_group() as tasks:
        for name in names:
            tasks.start_soon(see, name)
    # One after another: what is measured is how long they take, not how long we do.
    return tuple(
        [await _measured(_address(session, seen[name], own), seen[name], exchanges) for name in sorted(seen)]
    )


def _is_ours(node: NodeSeen) -> bool:
    return node.major == str(wire.MAJOR)


async def _tokens(session: AsyncSession, wanted: Collection[str]) -> frozenset[str]:
    """The tokens of nodes; waits a little for those that are wanted."""
    found: frozenset[str] = frozenset()
    with anyio.move_on_after(SEEN_WITHIN):
        while True:
            found = await session.list_tokens(wire.any_node_tokens(wire.NAMESPACE), SEEN_WITHIN)
            if {*wanted} <= {wire.token_node(token)[0] for token in found}:
                break
            await anyio.sleep(LOOK_AGAIN)
    return found


async def _first_look(address: NodeAddress, node: NodeSeen, *, may_use: bool) -> NodeSeen:
    """Whether a node answers at all, as the one that it says it is, and whether its robots may be used."""
    try:
        state = await ask(address, wire.GET_LAB_STATE, wire.Empty(), ANSWER_WITHIN)
        await address.prove()
    except (BackendError, InvalidUse) as error:
        return node.model_copy(update={"why": str(error)})
    seen: dict[str, object] = {"state": state}
    if may_use:
        try:
            await ask(address, wire.GET_ROBOT_FEATURES, wire.Empty(), ANSWER_WITHIN)
            seen["is_usable"] = True
        except BackendError as error:
            seen |= {"is_usable": False, "why_not": str(error)}
    return node.model_copy(update=seen)


async def _measured(address: NodeAddress, node: NodeSeen, exchanges: int) -> NodeSeen:
    if node.state is None:
        return node
    times: list[float] = []
    clock: Clock | None = None
    for _ in range(exchanges):
        try:
            await address.prove()  # once: it is not measured
            began, left = time.perf_counter(), time.time()
            state = await ask(address, wire.GET_LAB_STATE, wire.Empty(), ANSWER_WITHIN)
        except (BackendError, InvalidUse) as error:
            return node.model_copy(update={"why": str(error)})
        times.append(time.perf_counter() - began)
        if state.received is not None and state.sent is not None:
            found = compare(left, times[-1], state.received, state.sent)
            clock = found if clock is None or found.round_trip < clock.round_trip else clock
    half, most = quantiles(times)
    told = {} if clock is None else {"offset": clock.offset, "doubt": clock.round_trip / 2.0}
    return node.model_copy(update={"half": half, "most": most, "exchanges": exchanges, **told})


def quantiles(times: list[float]) -> tuple[float, float]:
    """Within what time half, and 99 %, of something was done."""
    ordered = sorted(times)
    return ordered[len(times) // 2], ordered[int(0.99 * len(times))]


def _address(session: AsyncSession, node: NodeSeen, keys: Keys | None) -> NodeAddress:
    return NodeAddress(session, wire.NAMESPACE, node.node, "lab", seals=node_seals(session, node.node, keys))
