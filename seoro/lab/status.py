"""State of a lab: its live nodes and executors, and the states of their robots."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterable, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import anyio
from anyio.abc import TaskStatus

from seoro.bridges import wire
from seoro.bridges.session import AsyncSession, SessionError, is_secured, open_session, open_session_at_once
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.concurrency.background import background
from seoro.concurrency.gathering import gather
from seoro.errors import BackendError, UsageError
from seoro.lab.reading import Lab
from seoro.lab.schema import BeforeFile
from seoro.security.network.endpoint_keys import ASKING, keys_for, security_of
from seoro.security.network.peers import node_signer

if TYPE_CHECKING:
    from seoro.security.keys.folder import Keys

TOKEN_TIMEOUT = 1.0  # [s] time limit of a hub to list live nodes
ANSWER_TIMEOUT = 2.0  # [s]


@dataclass(frozen=True)
class Member:
    """A node or an executor of a lab, or an endpoint without one.

    Attributes:
        endpoint: Endpoint of the node.
        node: Name; empty if no node was found.
        is_executor: Whether it is an executor.
        state: State of a node that was queried.
        problem: Problem of the member, as text; empty without one.
    """

    endpoint: str
    node: str = ""
    is_executor: bool = False
    state: wire.LabState | None = None
    problem: str = ""

    @property
    def robots(self) -> Sequence[wire.RobotState]:
        """States of its robots; empty without a state."""
        return () if self.state is None else self.state.robots

    @property
    def display_name(self) -> str:
        """Name in messages."""
        if not self.node:
            return self.endpoint
        return f"{'the executor' if self.is_executor else 'the node'} '{self.node}'"


def state_of(lab: wire.LabState, robot: wire.RobotState) -> str:
    """Return the state of a robot in words: `stopped`, `in use`, `leased` or `free`."""
    if lab.stopped is not None or robot.stopped is not None:
        return "stopped"
    if robot.holder:
        return "in use"
    return "free" if robot.lease is None else "leased"


@dataclass(frozen=True)
class ListedRobot:
    """A robot in a lab file.

    Attributes:
        remote_name: Name at its node.
        node: Name of its node; None for the only one at the endpoint.
        before: Its required state before a run.
    """

    name: str
    type: str
    endpoint: str
    remote_name: str
    node: str | None
    before: BeforeFile

    def is_served_by(self, member: Member) -> bool:
        """Whether a node serves the robot."""
        return member.endpoint == self.endpoint and self.node in (None, member.node)


def listed_robots(lab: Lab) -> list[ListedRobot]:
    """Return the robots of a lab file at running nodes."""
    found = []
    for name, robot in lab.robots.items():
        endpoint, node = lab.address(robot.where)
        if endpoint is not None:
            kind, there = robot.type or "", lab.remote_name(name)
            found.append(ListedRobot(name, kind, endpoint, there, node, robot.before))
    return found


@dataclass(frozen=True)
class Connection:
    """Connection to a member: its session (None if it is unreachable), and the keys of the session."""

    member: Member
    session: AsyncSession | None
    keys: Keys | None = None

    def address(self, session: AsyncSession) -> NodeAddress:
        """Return the address of a node; requests to nodes with keys are signed."""
        keys = self.keys if is_secured(self.member.endpoint) else None
        signer = node_signer(session, self.member.node, keys)
        return NodeAddress(session, wire.NAMESPACE, self.member.node, "lab's", signer=signer)


@asynccontextmanager
async def connect_endpoint(
    endpoint: str, folder: Path | None = None, *, is_repeated: bool = False
) -> AsyncIterator[tuple[AsyncSession, Keys | None]]:
    """Connect to an endpoint while the block lasts; yields the session and its keys.

    Args:
        endpoint: The endpoint.
        folder: Folder of keys, as in `connect_members`.
        is_repeated: Whether the caller tries again itself, so that no late process is waited for.

    Raises:
        SessionError: The endpoint is unreachable.
        UsageError: The keys are missing, or not valid there.
    """
    keys = keys_for(endpoint, ASKING, folder)
    opening = open_session_at_once if is_repeated else open_session
    async with opening(connect=endpoint, security=security_of(endpoint, keys)) as session:
        yield session, keys


@asynccontextmanager
async def connect_members(endpoints: Iterable[str], folder: Path | None = None) -> AsyncIterator[list[Connection]]:
    """Connect to all live nodes and executors at endpoints while the block lasts.

    The endpoints are tried concurrently, since unreachable ones take time; their order stays.

    Args:
        endpoints: Zenoh endpoints of nodes, executors, or their routers.
        folder: Folder of keys; None for `SEORO_KEYS`, else `~/.config/seoro/keys`.
    """
    async with background() as tasks:
        over = anyio.Event()

        async def reach(endpoint: str) -> list[Connection]:
            members: list[Connection] = await tasks.start(_reach, endpoint, folder, over)
            return members

        try:
            yield list(chain.from_iterable(await gather(reach, dict.fromkeys(endpoints))))
        finally:
            over.set()


async def _reach(
    endpoint: str, folder: Path | None, over: anyio.Event, *, task_status: TaskStatus[list[Connection]]
) -> None:
    try:
        async with connect_endpoint(endpoint, folder) as (session, keys):
            task_status.started(await members_at(endpoint, session, keys))
            await over.wait()
    except (SessionError, UsageError) as error:
        task_status.started([Connection(Member(endpoint, problem=str(error)), None)])


async def members_at(endpoint: str, session: AsyncSession, keys: Keys | None) -> list[Connection]:
    """Return the live nodes and executors at an endpoint, by the session and keys of `connect_endpoint`."""
    nodes = await session.list_tokens(wire.node_tokens(wire.NAMESPACE), TOKEN_TIMEOUT)
    executors = await session.list_tokens(wire.executor_tokens(wire.NAMESPACE), TOKEN_TIMEOUT)
    members = [Member(endpoint, name) for name in sorted({wire.token_node(token)[0] for token in nodes})]
    names = sorted({wire.token_node(token)[0] for token in executors})
    members += [Member(endpoint, name, is_executor=True) for name in names]
    if not members:
        members = [Member(endpoint, problem=f"no node or executor at {endpoint}")]
    return [Connection(member, session, keys) for member in members]


async def read_states(endpoints: Iterable[str], folder: Path | None = None) -> list[Member]:
    """Return the live members at endpoints with their states; see `connect_members` for the arguments."""
    async with connect_members(endpoints, folder) as reached:
        return list((await refresh(reached)).values())


async def refresh(reached: list[Connection]) -> dict[Connection, Member]:
    """Return connected members with their present states, by their connections."""

    async def query(each: Connection) -> Member:
        if each.session is None or not each.member.node or each.member.is_executor:
            return each.member
        address = each.address(each.session)
        try:
            state = await ask(address, wire.GET_LAB_STATE, wire.Empty(), ANSWER_TIMEOUT)
            await address.prove()
            return replace(each.member, state=state)
        except (BackendError, UsageError) as error:
            return replace(each.member, problem=str(error))

    return dict(zip(reached, await gather(query, reached), strict=True))
