"""What there is in a ROS 2 system: nodes, topics, services and actions, as its liveliness tokens tell.

A graph follows the tokens of one dialect: it is complete when it is opened, and what happens then arrives by
itself. Waiting for something to appear or to go is waiting for tokens; nothing polls.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Iterable, Iterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import TypeVar

import anyio

from seoro.background import background
from seoro.bridges.ros2.addresses import LARGEST_DOMAIN
from seoro.bridges.ros2.errors import NoSystem, WrongType
from seoro.bridges.ros2.wire import Dialect, Endpoint, Entity, Kind, Node, RmwZenoh, Ros2Dds, is_hidden
from seoro.bridges.session import AsyncSession, Mailbox
from seoro.changes import Changes
from seoro.errors import BackendError, InvalidUse

T = TypeVar("T")

LISTING_TIMEOUT = 5.0  # [s] that the hub may take to say what there is
MOST_TOKENS = 50_000  # of one system

_TOPIC = (Kind.PUBLISHER, Kind.SUBSCRIPTION)
_ACTION_PART = "/_action/"
_SEND_GOAL = "_SendGoal"
_ACTION_SERVICES = {
    "send_goal": "{}_SendGoal",
    "get_result": "{}_GetResult",
    "cancel_goal": "action_msgs/srv/CancelGoal",
}
_ACTION_TOPICS = {"feedback": "{}_FeedbackMessage", "status": "action_msgs/msg/GoalStatusArray"}


class RosGraph:
    """A ROS 2 system as it is now. Made by `open_graph`; for one event loop."""

    def __init__(self, dialect: Dialect) -> None:
        self.dialect = dialect
        self._nodes: dict[str, Node] = {}
        self._endpoints: dict[tuple[Kind, str], dict[str, Endpoint]] = {}
        self._entities: dict[str, Entity] = {}
        self._changes = Changes()

    def is_without(self, session: str) -> bool:
        """Whether nobody is there but a session itself."""
        return all(entity.session == session for entity in self._entities.values())

    def sessions(self) -> frozenset[str]:
        """The sessions of all who are there, as Zenoh calls them."""
        return frozenset(entity.session for entity in self._entities.values())

    def nodes(self) -> tuple[str, ...]:
        """The full names of all nodes, sorted; none behind a bridge, which tells of none."""
        return tuple(sorted({node.full_name for node in self._nodes.values()}))

    def endpoints(self) -> tuple[Endpoint, ...]:
        """All publishers, subscriptions, servers and clients."""
        return tuple(each for named in self._endpoints.values() for each in named.values())

    def publishers(self, topic: str) -> tuple[Endpoint, ...]:
        """The publishers of a topic; also one that an action consists of, where that is announced as a whole."""
        return self._of(Kind.PUBLISHER, topic) or self._of_action(topic, _ACTION_TOPICS, Kind.PUBLISHER)

    def subscriptions(self, topic: str) -> tuple[Endpoint, ...]:
        """The subscriptions of a topic."""
        return self._of(Kind.SUBSCRIPTION, topic)

    def servers(self, service: str) -> tuple[Endpoint, ...]:
        """Those that serve a service; also one that an action consists of, where that is announced as a whole."""
        return self._of(Kind.SERVER, service) or self._of_action(service, _ACTION_SERVICES, Kind.SERVER)

    def clients(self, service: str) -> tuple[Endpoint, ...]:
        """The clients of a service."""
        return self._of(Kind.CLIENT, service)

    def action_servers(self, action: str) -> tuple[Endpoint, ...]:
        """Those that serve an action: who is announced as such, or serves its goals."""
        announced = self._of(Kind.ACTION_SERVER, action)
        return announced or tuple(
            _as_action(server) for server in self.servers(f"{action}{_ACTION_PART}send_goal")
        )

    def topics(self, *, hidden: bool = False) -> dict[str, tuple[str, ...]]:
        """The topics with their types, sorted; more than one type if they do not agree."""
        return self._named(_TOPIC, hidden)

    def services(self, *, hidden: bool = False) -> dict[str, tuple[str, ...]]:
        """The services that are served, with their types, sorted."""
        return self._named((Kind.SERVER,), hidden)

    def actions(self) -> dict[str, tuple[str, ...]]:
        """The actions that are served, with their types, sorted."""
        found = {name for kind, name in self._endpoints if kind is Kind.ACTION_SERVER}
        ending = f"{_ACTION_PART}send_goal"
        found |= {
            name.removesuffix(ending)
            for kind, name in self._endpoints
            if kind is Kind.SERVER and name.endswith(ending)
        }
        return {name: types_of(self.action_servers(name)) for name in sorted(found)}

    def topic_type(self, topic: str) -> str | None:
        """The type of a topic, None if nobody has it.

        Raises:
            WrongType: Not all agree on it.
        """
        return _one_type(topic, (*self.publishers(topic), *self.subscriptions(topic)))

    def service_type(self, service: str) -> str | None:
        """The type of a service, None if nobody serves it.

        Raises:
            WrongType: Not all agree on it.
        """
        return _one_type(service, self.servers(service))

    async def wait_for(self, condition: Callable[[RosGraph], T], timeout: float | None = None) -> T:
        """Wait until a condition holds, looking at it whenever the system changes.

        Args:
            condition: Gives something true, which is returned, once it holds.
            timeout: [s] of the machine's clock; without end when None.

        Raises:
            TimeoutError: It did not hold in time.
        """
        return await self._changes.wait_for(lambda: condition(self), timeout)

    def change(self, changes: Iterable[tuple[str, bool]]) -> None:
        """Take over what has happened: (token, alive)."""
        for token, alive in changes:
            if alive:
                self._add(token)
            else:
                self._remove(token)
        self._changes.tell()

    @property
    def is_full(self) -> bool:
        """Whether there is more than is followed."""
        return len(self._entities) >= MOST_TOKENS

    def _add(self, token: str) -> None:
        if token in self._entities or self.is_full:
            return
        entity = self.dialect.parse(token)
        if entity is None:
            return
        self._entities[token] = entity
        if isinstance(entity, Node):
            self._nodes[token] = entity
        else:
            self._endpoints.setdefault((entity.kind, entity.name), {})[token] = entity

    def _remove(self, token: str) -> None:
        entity = self._entities.pop(token, None)
        if entity is None:
            return
        if isinstance(entity, Node):
            del self._nodes[token]
            return
        place = (entity.kind, entity.name)
        del self._endpoints[place][token]
        if not self._endpoints[place]:
            del self._endpoints[place]

    def _of(self, kind: Kind, name: str) -> tuple[Endpoint, ...]:
        return tuple(self._endpoints.get((kind, name), {}).values())

    def _of_action(self, name: str, parts: Mapping[str, str], kind: Kind) -> tuple[Endpoint, ...]:
        """What follows from the servers of an action that are announced, for one of its services or topics."""
        action, _, part = name.partition(_ACTION_PART)
        if part not in parts:
            return ()
        servers = self._of(Kind.ACTION_SERVER, action)
        return tuple(
            replace(server, kind=kind, name=name, type=parts[part].format(server.type)) for server in servers
        )

    def _named(self, kinds: tuple[Kind, ...], hidden: bool) -> dict[str, tuple[str, ...]]:
        names = {name for kind, name in self._endpoints if kind in kinds and (hidden or not is_hidden(name))}
        return {
            name: types_of([each for kind in kinds for each in self._of(kind, name)]) for name in sorted(names)
        }


@asynccontextmanager
async def open_graph(session: AsyncSession, dialect: Dialect) -> AsyncIterator[RosGraph]:
    """Follow a ROS 2 system; all that there is at this time is in the graph from its beginning.

    That holds for the first graph of a session. Zenoh mixes up what it tells those who ask again with the end of
    what it has told before, so that the next one may have to wait for some of it.

    Raises:
        BackendError: It has more nodes and endpoints than can be followed.
    """
    graph = RosGraph(dialect)
    async with session.token_changes(dialect.tokens) as changes:
        # What is there comes as changes, too, but nothing tells when that is all. A change is newer than the list.
        listed = await session.list_tokens(dialect.tokens, LISTING_TIMEOUT)
        _apply(graph, changes, ((token, True) for token in listed))
        async with background() as tasks:
            tasks.start_soon(_follow, graph, changes)
            yield graph


@asynccontextmanager
async def find_graph(session: AsyncSession, domain: int, timeout: float) -> AsyncIterator[RosGraph]:
    """Follow the system that a session reaches, whatever dialect it speaks; see `open_graph`.

    Args:
        session: Session to look with.
        domain: Domain of rmw_zenoh (ROS_DOMAIN_ID); a bridge has its own.
        timeout: [s] until something has to be seen.

    Raises:
        NoSystem: Nothing is seen; names other domains, if there are.
        InvalidUse: Both dialects are spoken.
    """
    own = session.identity
    async with open_graph(session, RmwZenoh(domain)) as native, open_graph(session, Ros2Dds()) as bridged:
        graphs = (native, bridged)
        with anyio.move_on_after(timeout):
            async with anyio.create_task_group() as tasks:

                async def look(graph: RosGraph) -> None:
                    await graph.wait_for(lambda seen: not seen.is_without(own))
                    tasks.cancel_scope.cancel()

                for graph in graphs:
                    tasks.start_soon(look, graph)
        match [graph for graph in graphs if not graph.is_without(own)]:
            case [found]:
                yield found
            case []:
                raise NoSystem(await _nothing_seen(session, domain, timeout))
            case _:
                raise InvalidUse(
                    "both rmw_zenoh and a bridge for DDS are seen",
                    help="say which of them to speak: `--dialect rmw_zenoh` or `--dialect ros2dds`; for runs, "
                    "`?dialect=` after the endpoint",
                )


async def _nothing_seen(session: AsyncSession, domain: int, timeout: float) -> str:
    tokens = await session.list_tokens("@ros2_lv/**", LISTING_TIMEOUT)
    domains = map(str, range(LARGEST_DOMAIN + 1))
    seen = {token.split("/")[1] for token in tokens}
    others = [each for each in domains if each in seen]
    problem = (
        f"no ROS 2 system is seen within {timeout:g} s: no node of rmw_zenoh in domain {domain}, and no bridge"
    )
    if others:
        return f"{problem}; there are nodes in domain {', '.join(others)}"
    return f"{problem}; is this the router that the robot's nodes use?"


async def _follow(graph: RosGraph, changes: Mailbox[tuple[str, bool]]) -> None:
    async for change in changes:
        _apply(graph, changes, (change,))


def _apply(graph: RosGraph, changes: Mailbox[tuple[str, bool]], first: Iterable[tuple[str, bool]]) -> None:
    """Take over what has happened: some of it first, then what waits."""
    graph.change((*first, *_waiting(changes)))
    if changes.lost or graph.is_full:
        raise BackendError(f"the ROS 2 system has more than can be followed ({MOST_TOKENS} nodes and endpoints)")


def _waiting(changes: Mailbox[tuple[str, bool]]) -> Iterator[tuple[str, bool]]:
    while (change := changes.take_now()) is not None:
        yield change


def types_of(endpoints: Iterable[Endpoint]) -> tuple[str, ...]:
    """The types that endpoints have, each once, sorted."""
    return tuple(sorted({endpoint.type for endpoint in endpoints}))


def _one_type(name: str, endpoints: Iterable[Endpoint]) -> str | None:
    types = types_of(endpoints)
    if len(types) > 1:
        raise WrongType(f"{name} has several types: {', '.join(types)}", help="say which of them is meant")
    return types[0] if types else None


def _as_action(server: Endpoint) -> Endpoint:
    """The server of an action, by the one of its goals."""
    name = server.name.partition(_ACTION_PART)[0]
    return replace(
        server, kind=Kind.ACTION_SERVER, name=name, type=server.type.removesuffix(_SEND_GOAL), type_hash=None
    )
