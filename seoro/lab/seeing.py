"""Seeing what there is in a lab: which nodes and executors are alive, and how their robots are."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import anyio
from anyio.abc import TaskStatus

from seoro.background import background
from seoro.bridges import wire
from seoro.bridges.seals import node_seals
from seoro.bridges.secured import ASKING, keys_for, security_of
from seoro.bridges.session import AsyncSession, SessionError, is_secured, open_session
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.errors import BackendError, InvalidUse
from seoro.lab.reading import Lab

if TYPE_CHECKING:
    from seoro.keys.folder import Keys

SEEN_WITHIN = 1.0  # [s] that a hub may take to say who is alive
ANSWER_WITHIN = 2.0  # [s]


@dataclass(frozen=True)
class Member:
    """A node or an executor of a lab, or an endpoint at which there is none.

    Attributes:
        endpoint: Where it was found.
        node: Its name; empty if there is none.
        is_executor: Whether it is an executor.
        state: How it is, of a node that has been asked.
        why: What is wrong with it, in words; empty if nothing is.
    """

    endpoint: str
    node: str = ""
    is_executor: bool = False
    state: wire.LabState | None = None
    why: str = ""

    @property
    def called(self) -> str:
        """What messages call it."""
        if not self.node:
            return self.endpoint
        return f"{'the executor' if self.is_executor else 'the node'} '{self.node}'"


@dataclass(frozen=True)
class Known:
    """What a lab file says of a robot: what it calls it, what it is, and where it should be.

    Attributes:
        called: Its name at its node.
        node: That of its node; None for the only one at the endpoint.
    """

    name: str
    type: str
    endpoint: str
    called: str
    node: str | None

    def is_at(self, member: Member) -> bool:
        """Whether it lives at a node."""
        return member.endpoint == self.endpoint and self.node in (None, member.node)


def known_of(lab: Lab) -> list[Known]:
    """The robots of a lab file that live somewhere without a run."""
    found = []
    for name, robot in lab.robots.items():
        endpoint, node = lab.address(robot.where)
        if endpoint is not None:
            found.append(Known(name, robot.type or "", endpoint, lab.called(name), node))
    return found


@dataclass(frozen=True)
class Reached:
    """A member, the session by which it is asked, None where nothing answers, and the keys that are used there."""

    member: Member
    session: AsyncSession | None
    keys: Keys | None = None

    @property
    def own_keys(self) -> Keys | None:
        """The keys by which nodes know who asks; None where they have none."""
        return self.keys if is_secured(self.member.endpoint) else None

    def address(self, session: AsyncSession) -> NodeAddress:
        """How it is asked, of a node."""
        seals = node_seals(session, self.member.node, self.own_keys)
        return NodeAddress(session, wire.NAMESPACE, self.member.node, "lab's", seals=seals)


@asynccontextmanager
async def connected(endpoint: str, folder: Path | None = None) -> AsyncIterator[tuple[AsyncSession, Keys | None]]:
    """Be connected to an endpoint for as long as the block lasts, with the keys that are used there.

    Raises:
        SessionError: Nothing answers there.
        InvalidUse: It is of no use without keys, or with those that there are.
    """
    keys = keys_for(endpoint, ASKING, folder)
    async with open_session(connect=endpoint, security=security_of(endpoint, keys)) as session:
        yield session, keys


def nobody(endpoint: str, why: str) -> Reached:
    """What is reached at an endpoint where there is nobody."""
    return Reached(Member(endpoint, why=why), None)


@asynccontextmanager
async def reaching(endpoints: Iterable[str], folder: Path | None = None) -> AsyncIterator[list[Reached]]:
    """Be connected to all who are alive at endpoints, for as long as the block lasts.

    All endpoints are tried at once, since each that does not answer takes its time; their order stays.

    Args:
        endpoints: Zenoh endpoints of nodes, of executors, or of routers that these are connected to.
        folder: Of keys; None for that of the environment variable `SEORO_KEYS`, else `~/.config/seoro/keys`.
    """
    async with background() as tasks:
        found: dict[str, list[Reached]] = {endpoint: [] for endpoint in endpoints}
        over = anyio.Event()

        async def reach(endpoint: str) -> None:
            found[endpoint] = await tasks.start(_reach, endpoint, folder, over)

        try:
            async with anyio.create_task_group() as trying:
                for endpoint in found:
                    trying.start_soon(reach, endpoint)
            yield [each for members in found.values() for each in members]
        finally:
            over.set()


async def _reach(
    endpoint: str, folder: Path | None, over: anyio.Event, *, task_status: TaskStatus[list[Reached]]
) -> None:
    try:
        async with connected(endpoint, folder) as (session, keys):
            task_status.started(await members_at(endpoint, session, keys))
            await over.wait()
    except (SessionError, InvalidUse) as error:
        task_status.started([nobody(endpoint, str(error))])


async def members_at(endpoint: str, session: AsyncSession, keys: Keys | None) -> list[Reached]:
    """Who is alive at an endpoint, by the session and the keys of `connected`."""
    nodes = await session.list_tokens(wire.node_tokens(wire.NAMESPACE), SEEN_WITHIN)
    executors = await session.list_tokens(wire.executor_tokens(wire.NAMESPACE), SEEN_WITHIN)
    members = [Member(endpoint, name) for name in sorted({wire.token_node(token)[0] for token in nodes})]
    names = sorted({wire.token_node(token)[0] for token in executors})
    members += [Member(endpoint, name, is_executor=True) for name in names]
    if not members:
        members = [Member(endpoint, why=f"nobody lives at {endpoint}")]
    return [Reached(member, session, keys) for member in members]


async def look(endpoints: Iterable[str], folder: Path | None = None) -> list[Member]:
    """All who are alive at endpoints, nodes with how their robots are; arguments as those of `reaching`."""
    async with reaching(endpoints, folder) as reached:
        return await asking(reached)


async def asking(reached: list[Reached]) -> list[Member]:
    """The same who have been reached already, as they are now."""
    seen: list[Member] = [each.member for each in reached]

    async def ask_one(index: int, each: Reached) -> None:
        assert each.session is not None
        address = each.address(each.session)
        try:
            state = await ask(address, wire.GET_LAB_STATE, wire.Empty(), ANSWER_WITHIN)
            await address.prove()
            seen[index] = replace(each.member, state=state)
        except (BackendError, InvalidUse) as error:
            seen[index] = replace(each.member, why=str(error))

    async with anyio.create_task_group() as tasks:
        for index, each in enumerate(reached):
            if each.session is not None and each.member.node and not each.member.is_executor:
                tasks.start_soon(partial(ask_one, index, each))
    return seen
