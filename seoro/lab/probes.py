"""Probes of the nodes of a lab from here: presence, authenticity, rights, clock and latency."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Collection
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

from seoro.bridges import wire
from seoro.bridges.executor.clocks import Clock, compare
from seoro.bridges.executor.probing import EndpointReport, Hop, NodeReport
from seoro.bridges.naming import wait_for_tokens
from seoro.bridges.serving.node import KIND
from seoro.bridges.session import AsyncSession, Security, SessionError, is_secured, open_session
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.concurrency.gathering import gather
from seoro.errors import BackendError, UsageError
from seoro.security.keys.roles import MOVING
from seoro.security.network.endpoint_keys import ASKING, check_reached, keys_for, security_of
from seoro.security.network.peers import node_signer

if TYPE_CHECKING:
    from seoro.security.keys.folder import Keys

EXCHANGES: Final = 100  # to measure the latency
TOKEN_TIMEOUT: Final = 2.0  # [s] time limit for expected nodes to appear
ANSWER_WITHIN: Final = 2.0  # [s]
CHECK_TIMEOUT: Final = 15.0  # [s] for the check of a robot, which waits for its messages


async def probe(
    endpoint: str, folder: Path | None = None, wanted: Collection[str] = (), exchanges: int = EXCHANGES
) -> EndpointReport:
    """Probe an endpoint from here.

    Args:
        endpoint: The endpoint.
        folder: Folder of keys, as for commands.
        wanted: Names of expected nodes, which get a moment to appear.
        exchanges: Number of measured exchanges with each node.
    """
    try:
        keys = keys_for(endpoint, ASKING, folder)
        security = security_of(endpoint, keys)
    except UsageError as error:
        return EndpointReport(endpoint=endpoint, ends_at=Hop.KEYS, why=str(error), advice=error.help)
    who = client_identity(endpoint, keys)
    try:
        async with open_session(connect=endpoint, security=security) as session:
            nodes = await probe_nodes(session, endpoint, keys, wanted, exchanges)
            return EndpointReport(endpoint=endpoint, who=who, nodes=nodes)
    except SessionError as error:
        why, advice = explain_unreached(endpoint, error, security)
        return EndpointReport(endpoint=endpoint, who=who, ends_at=Hop.SESSION, why=why, advice=advice)


def client_identity(endpoint: str, keys: Keys | None) -> str:
    """Return the name and role of a client with keys; empty at endpoints without keys."""
    return str(keys.identity) if keys is not None and is_secured(endpoint) else ""


def explain_unreached(endpoint: str, error: SessionError, security: Security | None) -> tuple[str, str]:
    """Return the reason why no session can be opened at an endpoint, and how to fix it."""
    try:
        check_reached(endpoint, security)
    except UsageError as reason:
        return str(reason), reason.help
    return (
        f"no Zenoh session with {endpoint}: {error}",
        "check that an executor, a node or a router of seoro listens there, and that it is not suspended "
        "(`kill -STOP`, a debugger)",
    )


async def probe_nodes(
    session: AsyncSession,
    endpoint: str,
    keys: Keys | None,
    wanted: Collection[str] = (),
    exchanges: int = EXCHANGES,
) -> tuple[NodeReport, ...]:
    """Probe all nodes that a session reaches; see `probe`. The reports are sorted by name."""

    def has_wanted(tokens: frozenset[str]) -> bool:
        return {*wanted} <= {wire.token_node(token)[0] for token in tokens}

    found = await wait_for_tokens(session, wire.any_node_tokens(wire.NAMESPACE), TOKEN_TIMEOUT, has_wanted)
    names = Counter(wire.token_node(token)[0] for token in found)
    majors = {wire.token_node(token)[0]: wire.token_major(token) for token in sorted(found)}
    own = keys if is_secured(endpoint) else None
    may_use = own is None or own.identity.role in MOVING

    async def contact(name: str) -> NodeReport:
        node = NodeReport(node=name, count=names[name], major=majors[name])
        if node.major != str(wire.MAJOR):
            return node
        return await _contact(_address(session, node, own), node, may_use=may_use)

    seen = await gather(contact, sorted(names))
    # Sequential, so that the measurements do not disturb each other.
    return tuple([await _measure(_address(session, node, own), node, exchanges) for node in seen])


async def _contact(address: NodeAddress, node: NodeReport, *, may_use: bool) -> NodeReport:
    """Check that a node answers, that it is authentic, and that its robots may be used."""
    try:
        state = await ask(address, wire.GET_LAB_STATE, wire.Empty(), ANSWER_WITHIN)
        await address.prove()
    except (BackendError, UsageError) as error:
        return node.model_copy(update={"why": str(error)})
    seen: dict[str, object] = {"state": state, "checks": await _check_robots(address, state)}
    if may_use:
        try:
            await ask(address, wire.GET_ROBOT_FEATURES, wire.Empty(), ANSWER_WITHIN)
            seen["is_usable"] = True
        except BackendError as error:
            seen |= {"is_usable": False, "why_not": str(error)}
    return node.model_copy(update=seen)


async def _check_robots(address: NodeAddress, state: wire.LabState) -> dict[str, wire.RobotCheck]:
    """Return the checks of the robots of a bridge, by their names; none of nodes that do not check robots."""
    checks: dict[str, wire.RobotCheck] = {}

    async def check(name: str) -> None:
        with suppress(BackendError):
            checks[name] = await ask(address, wire.CHECK_ROBOT, wire.RobotName(robot=name), CHECK_TIMEOUT)

    if state.kind == KIND:
        await gather(check, [robot.name for robot in state.robots])
    return checks


async def _measure(address: NodeAddress, node: NodeReport, exchanges: int) -> NodeReport:
    if node.state is None:
        return node
    times: list[float] = []
    clock: Clock | None = None
    for _ in range(exchanges):
        try:
            await address.prove()  # only the first time, before the measurement
            began, left = time.perf_counter(), time.time()
            state = await ask(address, wire.GET_LAB_STATE, wire.Empty(), ANSWER_WITHIN)
        except (BackendError, UsageError) as error:
            return node.model_copy(update={"why": str(error)})
        times.append(time.perf_counter() - began)
        if state.received is not None and state.sent is not None:
            found = compare(left, times[-1], state.received, state.sent)
            clock = found if clock is None or found.round_trip < clock.round_trip else clock
    half, most = quantiles(times)
    measured = {} if clock is None else {"offset": clock.offset, "doubt": clock.round_trip / 2.0}
    return node.model_copy(update={"half": half, "most": most, "exchanges": exchanges, **measured})


def quantiles(times: list[float]) -> tuple[float, float]:
    """Return the median and the 99th percentile of times."""
    ordered = sorted(times)
    return ordered[len(times) // 2], ordered[int(0.99 * len(times))]


def _address(session: AsyncSession, node: NodeReport, keys: Keys | None) -> NodeAddress:
    return NodeAddress(session, wire.NAMESPACE, node.node, "lab", signer=node_signer(session, node.node, keys))
