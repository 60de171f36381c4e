"""Graph of a ROS 2 system: nodes, topics, services and actions, from its liveliness tokens.

A graph follows the tokens of one dialect. It is complete when it is opened, and later changes arrive by
themselves. Waiting for an entity means waiting for its token, without polling.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Iterable, Iterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import TypeVar

import anyio

from seoro.bridges.addresses import LARGEST_DOMAIN
from seoro.bridges.ros2.errors import NoSystem
from seoro.bridges.ros2.router_checks import REMEDY, hidden_peers
from seoro.bridges.ros2.wire import Dialect, Endpoint, Entity, Kind, Node, RmwZenoh, Ros2Dds, is_hidden
from seoro.bridges.session import AsyncSession, Mailbox
from seoro.concurrency.background import background
from seoro.concurrency.condition import Condition
from seoro.errors import BackendError, UsageError

T = TypeVar("T")

LISTING_TIMEOUT = 5.0  # [s] for the router to list the tokens
MAX_TOKENS = 50_000  # size limit of a system

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
    """Present state of a ROS 2 system. Made by `open_graph`; for one event loop."""

    def __init__(self, dialect: Dialect) -> None:
        self.dialect = dialect
        self._endpoints: dict[tuple[Kind, str], dict[str, Endpoint]] = {}
        self._entities: dict[str, Entity] = {}
        self._changes = Condition()

    def has_others(self, session: str) -> bool:
        """Return whether the system has nodes or endpoints of other sessions."""
        return any(entity.session != session for entity in self._entities.values())

    def sessions(self) -> frozenset[str]:
        """Return the Zenoh IDs of the sessions of all nodes and endpoints."""
        return frozenset(entity.session for entity in self._entities.values())

    def nodes(self) -> tuple[str, ...]:
        """Return the full names of all nodes, sorted; none behind a bridge for DDS, which announces no nodes."""
        return tuple(sorted({each.full_name for each in self._entities.values() if isinstance(each, Node)}))

    def endpoints(self) -> tuple[Endpoint, ...]:
        """Return all publishers, subscriptions, servers and clients."""
        return tuple(each for named in self._endpoints.values() for each in named.values())

    def publishers(self, topic: str) -> tuple[Endpoint, ...]:
        """Return the publishers of a topic, which may be part of an action that is announced as a whole."""
        return self._of(Kind.PUBLISHER, topic) or self._of_action(topic, _ACTION_TOPICS, Kind.PUBLISHER)

    def subscriptions(self, topic: str) -> tuple[Endpoint, ...]:
        """Return the subscriptions of a topic."""
        return self._of(Kind.SUBSCRIPTION, topic)

    def servers(self, service: str) -> tuple[Endpoint, ...]:
        """Return the servers of a service, which may be part of an action that is announced as a whole."""
        return self._of(Kind.SERVER, service) or self._of_action(service, _ACTION_SERVICES, Kind.SERVER)

    def clients(self, service: str) -> tuple[Endpoint, ...]:
        """Return the clients of a service."""
        return self._of(Kind.CLIENT, service)

    def action_servers(self, action: str) -> tuple[Endpoint, ...]:
        """Return the servers of an action: announced as such, or servers of its `send_goal`."""
        announced = self._of(Kind.ACTION_SERVER, action)
        return announced or tuple(
            _as_action(server) for server in self.servers(f"{action}{_ACTION_PART}send_goal")
        )

    def topics(self, *, hidden: bool = False) -> dict[str, tuple[str, ...]]:
        """Return the topics with their types, sorted; several types if the endpoints differ."""
        return self._named(_TOPIC, hidden)

    def services(self, *, hidden: bool = False) -> dict[str, tuple[str, ...]]:
        """Return the services that have servers, with their types, sorted."""
        return self._named((Kind.SERVER,), hidden)

    def actions(self) -> dict[str, tuple[str, ...]]:
        """Return the actions that have servers, with their types, sorted."""
        found = {name for kind, name in self._endpoints if kind is Kind.ACTION_SERVER}
        ending = f"{_ACTION_PART}send_goal"
        found |= {
            name.removesuffix(ending)
            for kind, name in self._endpoints
            if kind is Kind.SERVER and name.endswith(ending)
        }
        return {name: types_of(self.action_servers(name)) for name in sorted(found)}

    async def wait_for(self, condition: Callable[[RosGraph], T], timeout: float | None = None) -> T:
        """Wait until a condition holds; check it now and after each change of the system.

        Args:
            condition: Function whose first true result is returned.
            timeout: Time limit [s] of the machine's clock; None for no limit.

        Raises:
            TimeoutError: The condition did not hold in time.
        """
        return await self._changes.wait_for(lambda: condition(self), timeout)

    def change(self, changes: Iterable[tuple[str, bool]]) -> None:
        """Apply changes: tokens, with whether they are alive."""
        for token, alive in changes:
            if alive:
                self._add(token)
            else:
                self._remove(token)
        self._changes.notify_all()

    @property
    def is_full(self) -> bool:
        """Whether the graph has reached its size limit."""
        return len(self._entities) >= MAX_TOKENS

    def _add(self, token: str) -> None:
        if token in self._entities or self.is_full:
            return
        entity = self.dialect.parse(token)
        if entity is None:
            return
        self._entities[token] = entity
        if isinstance(entity, Endpoint):
            self._endpoints.setdefault((entity.kind, entity.name), {})[token] = entity

    def _remove(self, token: str) -> None:
        entity = self._entities.pop(token, None)
        if isinstance(entity, Endpoint):
            key = (entity.kind, entity.name)
            del self._endpoints[key][token]
            if not self._endpoints[key]:
                del self._endpoints[key]

    def _of(self, kind: Kind, name: str) -> tuple[Endpoint, ...]:
        return tuple(self._endpoints.get((kind, name), {}).values())

    def _of_action(self, name: str, parts: Mapping[str, str], kind: Kind) -> tuple[Endpoint, ...]:
        """Return the endpoints of a service or topic of an action that is announced as a whole."""
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
    """Follow a ROS 2 system; the graph has all present nodes and endpoints from its beginning.

    This holds for the first graph of a session. For a repeated query, Zenoh may mix the answers with the end of an
    earlier query, so tokens may be missing from a later graph for a while.

    Raises:
        BackendError: The system has too many nodes and endpoints.
    """
    graph = RosGraph(dialect)
    async with session.tokens(dialect.tokens) as changes:
        # Present tokens arrive as changes, too, but their end is not marked. A change is newer than the list.
        listed = await session.list_tokens(dialect.tokens, LISTING_TIMEOUT)
        _apply(graph, changes, ((token, True) for token in listed))
        async with background() as tasks:
            tasks.start_soon(_follow, graph, changes)
            yield graph


@asynccontextmanager
async def find_graph(session: AsyncSession, domain: int, timeout: float) -> AsyncIterator[RosGraph]:
    """Detect the dialect of the system behind a session, and follow the system; see `open_graph`.

    Args:
        session: Session of the search.
        domain: Domain of rmw_zenoh (ROS_DOMAIN_ID); a bridge for DDS has its own.
        timeout: Time limit of the search [s].

    Raises:
        NoSystem: No node or bridge was found; the message has the domains of other nodes.
        UsageError: Both dialects are in use.
    """
    own = session.identity
    async with open_graph(session, RmwZenoh(domain)) as native, open_graph(session, Ros2Dds()) as bridged:
        graphs = (native, bridged)
        with anyio.move_on_after(timeout):
            async with anyio.create_task_group() as tasks:

                async def look(graph: RosGraph) -> None:
                    await graph.wait_for(lambda seen: seen.has_others(own))
                    tasks.cancel_scope.cancel()

                for graph in graphs:
                    tasks.start_soon(look, graph)
        match [graph for graph in graphs if graph.has_others(own)]:
            case [found]:
                yield found
            case []:
                raise NoSystem(await _nothing_seen(session, domain, timeout))
            case _:
                raise UsageError(
                    "found both rmw_zenoh and a bridge for DDS",
                    help="select one with `--dialect rmw_zenoh` or `--dialect ros2dds`; for runs, "
                    "`?dialect=` after the endpoint",
                )


async def _nothing_seen(session: AsyncSession, domain: int, timeout: float) -> str:
    tokens = await session.list_tokens("@ros2_lv/**", LISTING_TIMEOUT)
    domains = map(str, range(LARGEST_DOMAIN + 1))
    seen = {token.split("/")[1] for token in tokens}
    others = [each for each in domains if each in seen]
    problem = f"no ROS 2 system within {timeout:g} s: no node of rmw_zenoh in domain {domain}, and no bridge"
    if others:
        return f"{problem}; nodes are in domain {', '.join(others)}"
    if hidden := await hidden_peers(session):
        return f"{problem}; {hidden}: {REMEDY}"
    return f"{problem}; is this the router that the robot's nodes use?"


async def _follow(graph: RosGraph, changes: Mailbox[tuple[str, bool]]) -> None:
    async for change in changes:
        _apply(graph, changes, (change,))


def _apply(graph: RosGraph, changes: Mailbox[tuple[str, bool]], first: Iterable[tuple[str, bool]]) -> None:
    """Apply changes: first the given ones, then the queued ones."""
    graph.change((*first, *_waiting(changes)))
    if changes.dropped or graph.is_full:
        raise BackendError(f"the ROS 2 system has too many nodes and endpoints (limit: {MAX_TOKENS})")


def _waiting(changes: Mailbox[tuple[str, bool]]) -> Iterator[tuple[str, bool]]:
    while (change := changes.get_nowait()) is not None:
        yield change


def types_of(endpoints: Iterable[Endpoint]) -> tuple[str, ...]:
    """Return the types of endpoints without duplicates, sorted."""
    return tuple(sorted({endpoint.type for endpoint in endpoints}))


def _as_action(server: Endpoint) -> Endpoint:
    """Convert the server of `send_goal` to the server of the action."""
    name = server.name.partition(_ACTION_PART)[0]
    return replace(
        server, kind=Kind.ACTION_SERVER, name=name, type=server.type.removesuffix(_SEND_GOAL), type_hash=None
    )
