"""Nodes of seoro in a ROS 2 system, with publishers, subscriptions, clients and servers.

Each of them is a context manager: it is announced during its block only.
"""

from __future__ import annotations

import itertools
from collections.abc import AsyncIterator, Iterable, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path

import anyio.to_thread

from seoro.bridges.addresses import ROS_ROUTER
from seoro.bridges.ros2 import wire
from seoro.bridges.ros2.errors import NoSystem
from seoro.bridges.ros2.graph import RosGraph, find_graph, open_graph
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.services import BUSY, WAITING, Client, Handler, Server
from seoro.bridges.ros2.topics import KEEP_ALL, Publication, Subscription
from seoro.bridges.ros2.type_matching import announced_hash, check_type, match_types, matching_hash
from seoro.bridges.session import (
    AsyncSession,
    Bound,
    InvalidEndpoint,
    SessionError,
    is_local,
    open_session,
    publishing,
    subscribing,
)
from seoro.concurrency.background import background
from seoro.errors import UsageError

BRIDGE, GUARD = "seoro_bridge", "seoro_guard"  # names of the nodes of bridges and their guards
DISCOVERY_TIMEOUT = 3.0  # [s] to detect the dialect of a system
SERVICE_QOS = wire.PRESETS["services_default"]


@dataclass(frozen=True)
class RosOptions:
    """Options of a connection to a ROS 2 system.

    Args:
        endpoint: Zenoh endpoint of the router that the robot's nodes use, or of the bridge.
        domain: ROS_DOMAIN_ID.
        dialect: `rmw_zenoh` or `ros2dds`; None to detect it.
        interfaces: Folders with interface packages, which replace packages of the same name in seoro.
        distribution: ROS 2 distribution of the interface packages in seoro.
    """

    endpoint: str
    domain: int = 0
    dialect: str | None = None
    interfaces: Sequence[Path] = ()
    distribution: str = "jazzy"


@dataclass(frozen=True)
class RosSystem:
    """A connected ROS 2 system. Made by `open_system`.

    Attributes:
        session: Session of the connection.
        graph: Graph of the system.
        types: Type definitions that seoro knows.
    """

    session: AsyncSession
    graph: RosGraph
    types: TypeStore
    _numbers: itertools.count[int] = field(default_factory=itertools.count, repr=False)

    @property
    def dialect(self) -> wire.Dialect:
        """Mapping of ROS 2 to Zenoh."""
        return self.graph.dialect

    def prepare(self) -> None:
        """Load the encoder, whose import is slow and would delay the first message."""
        self.types.encode("std_msgs/msg/Empty", {})

    @asynccontextmanager
    async def node(self, name: str = "seoro", namespace: str = "/") -> AsyncIterator[RosNode]:
        """Create a node for the duration of the block.

        Raises:
            InvalidName: The name or the namespace is invalid.
        """
        names = wire.check_node_name(name), wire.resolve_namespace(namespace)
        node = wire.Node(self.session.identity, self.number(), *names)
        token = self.dialect.token(node)
        if token is None:
            yield RosNode(self, node)
            return
        async with self.session.token(token):
            yield RosNode(self, node)

    def number(self) -> int:
        """Return a new number for a node or an endpoint."""
        return next(self._numbers)


@dataclass(frozen=True)
class RosNode:
    """A node of seoro. Made by `RosSystem.node`.

    Names of topics and services may be relative to its namespace, or private (`~/name`).
    """

    system: RosSystem
    node: wire.Node

    @property
    def graph(self) -> RosGraph:
        """Graph of the system."""
        return self.system.graph

    def resolve(self, name: str) -> str:
        """Return the full name of a topic, service or action.

        Raises:
            InvalidName: The name is invalid.
        """
        return wire.resolve(name, self.node.namespace, self.node.name)

    def others(self, endpoints: Iterable[wire.Endpoint]) -> tuple[wire.Endpoint, ...]:
        """Return the endpoints of other sessions."""
        return tuple(each for each in endpoints if each.session != self.node.session)

    @asynccontextmanager
    async def publishing(
        self, topic: str, type_name: str, qos: wire.Qos | None = None, *, type_hash: str | None = None
    ) -> AsyncIterator[Publication]:
        """Create a publisher for the duration of the block.

        Args:
            topic: Name of the topic.
            type_name: Type of the messages.
            qos: Offered QoS profile; None for reliable, volatile and a depth of 10.
            type_hash: Type hash of messages that are sent as CDR (`Publication.send`), which seoro need not know;
                None for messages that seoro encodes.

        Raises:
            InvalidName, UnknownInterface: The name or type is invalid.
            WrongType, DefinitionMismatch: The subscriptions have another type, or another definition of it.
        """
        system, offered = self.system, qos or wire.Qos()
        topic, types = self.resolve(topic), system.types
        others = self.others(self.graph.subscriptions(topic))
        if type_hash is None:
            type_name = types.canonical(type_name)
            type_hash, types = match_types(topic, type_name, others, types)
        else:
            type_hash = matching_hash(topic, type_name, others, type_hash)
        check_type(topic, type_name, self.others(self.graph.publishers(topic)))
        token = self._token(wire.Kind.PUBLISHER, topic, type_name, type_hash, offered)
        keep = offered.depth if offered.is_transient_local else 0
        key = system.dialect.key(topic, type_name, type_hash)
        async with (
            publishing(
                system.session, key, reliable=offered.is_reliable, keep=keep, recover=offered.is_reliable
            ) as publisher,
            system.session.token(token),
        ):

            def check() -> None:
                if type_hash is not None:
                    matching_hash(topic, type_name, self.others(self.graph.subscriptions(topic)), type_hash)

            gid = system.dialect.gid(token)
            yield Publication(topic, type_name, offered, publisher, system.dialect, gid, types, check)

    @asynccontextmanager
    async def subscribing(
        self,
        topic: str,
        type_name: str,
        qos: wire.Qos | None = None,
        bound: Bound | None = None,
        *,
        is_decoded: bool = True,
        is_checked: bool = True,
    ) -> AsyncIterator[Subscription]:
        """Create a subscription for the duration of the block.

        Args:
            topic: Name of the topic.
            type_name: Type of the messages; if seoro does not know it, messages can be received, but not decoded.
            qos: Requested QoS profile; None for reliable, volatile and a depth of 10.
            bound: Capacity and drop policy of the queue; None for those of the QoS profile.
            is_decoded: Whether messages will be decoded; the decoder is prepared before the first message.
            is_checked: Whether publishers of another type are an error; otherwise they are ignored.

        Raises:
            InvalidName: The name is invalid.
            WrongType: The topic has another type.
        """
        system, requested = self.system, qos or wire.Qos()
        topic = self.resolve(topic)
        publishers = self.others(self.graph.publishers(topic))
        if type_name not in {publisher.type for publisher in publishers}:
            type_name = system.types.canonical(type_name)
        if is_checked:
            check_type(topic, type_name, publishers)
        if is_decoded and type_name in system.types.names():
            system.types.prepare(type_name)
        type_hash = announced_hash(type_name, publishers, system.types)
        token = self._token(wire.Kind.SUBSCRIPTION, topic, type_name, type_hash, requested)
        history = requested.depth if requested.is_transient_local else 0
        if bound is None:
            bound = KEEP_ALL if requested.history is wire.History.KEEP_ALL else Bound(requested.depth)
        key = system.dialect.key_expression(topic, type_name)
        subscription = Subscription(topic, type_name, bound, system.dialect, system.types)
        on_sample, recover = subscription.on_sample, requested.is_reliable
        # The token comes first: publishers of large messages look for it before they choose the key.
        async with (
            system.session.token(token),
            subscribing(system.session, key, on_sample, history=history, recover=recover),
        ):
            try:
                yield subscription
            finally:
                subscription.close()

    @asynccontextmanager
    async def calling(self, service: str, type_name: str) -> AsyncIterator[Client]:
        """Create a client of a service for the duration of the block.

        Raises:
            InvalidName, UnknownInterface: The name or type is invalid.
        """
        system = self.system
        service, type_name = self.resolve(service), system.types.canonical(type_name)
        type_hash = announced_hash(type_name, self.graph.servers(service), system.types)
        token = self._token(wire.Kind.CLIENT, service, type_name, type_hash, SERVICE_QOS)
        async with system.session.token(token):
            yield Client(service, type_name, system.session, self.graph, system.dialect.gid(token), system.types)

    @asynccontextmanager
    async def serving(self, service: str, type_name: str, handler: Handler) -> AsyncIterator[None]:
        """Serve a service for the duration of the block.

        Args:
            service: Name of the service.
            type_name: Type of the service.
            handler: Returns the response to a request; see `Server`.

        Raises:
            InvalidName, UnknownInterface: The name or type is invalid.
        """
        system = self.system
        service, type_name = self.resolve(service), system.types.canonical(type_name)
        type_hash = system.types.type_hash(type_name)
        token = self._token(wire.Kind.SERVER, service, type_name, type_hash, SERVICE_QOS)
        key = system.dialect.key(service, type_name, type_hash)
        server = Server(type_name, handler, system.dialect, system.types)
        async with (
            system.session.answering(key, WAITING, BUSY) as requests,
            system.session.token(token),
            background() as tasks,
        ):
            tasks.start_soon(server.run, requests)
            yield

    def _token(self, kind: wire.Kind, name: str, type_name: str, type_hash: str | None, qos: wire.Qos) -> str:
        """Return the token of a new endpoint."""
        session, number = self.system.session.identity, self.system.number()
        endpoint = wire.Endpoint(kind, name, type_name, session, type_hash, qos, number, self.node)
        token = self.system.dialect.token(endpoint)
        assert token is not None, "all dialects announce topics and services"
        return token


@asynccontextmanager
async def open_system(
    session: AsyncSession, types: TypeStore, *, dialect: wire.Dialect | None = None, domain: int = 0
) -> AsyncIterator[RosSystem]:
    """Open the ROS 2 system behind a session.

    Args:
        session: Session that is connected to the robot's router, or to its bridge.
        types: Definitions of types.
        dialect: Dialect of the system; None to detect it.
        domain: Domain to search when the dialect is detected (ROS_DOMAIN_ID).

    Raises:
        NoSystem: No node or bridge was found.
        UsageError: Both dialects are in use.
    """
    following = find_graph(session, domain, DISCOVERY_TIMEOUT) if dialect is None else open_graph(session, dialect)
    async with following as graph:
        yield RosSystem(session, graph, types)


@asynccontextmanager
async def connect(
    endpoint: str = ROS_ROUTER,
    *,
    types: TypeStore | None = None,
    dialect: wire.Dialect | None = None,
    domain: int = 0,
) -> AsyncIterator[RosSystem]:
    """Connect to a router, and open the ROS 2 system behind it; see `open_system`.

    Args:
        endpoint: Zenoh endpoint of the router that the robot's nodes use, or of the bridge; by default on this
            machine.
        types: Definitions of types; None for the definitions of seoro.
        dialect: Dialect of the system; None to detect it.
        domain: Domain to search when the dialect is detected (ROS_DOMAIN_ID).

    Raises:
        NoSystem: The endpoint is unreachable, or no node or bridge was found.
        UsageError: The endpoint is invalid, or both dialects are in use.
    """
    async with AsyncExitStack() as stack:
        try:
            opening = open_session(connect=endpoint, patient=False, gossip=is_local(endpoint))
            session = await stack.enter_async_context(opening)
        except InvalidEndpoint as error:
            raise UsageError(str(error)) from None
        except SessionError as error:
            raise NoSystem(f"cannot connect to {endpoint}: no router and no bridge answers there") from error
        system = open_system(session, types or TypeStore.bundled(), dialect=dialect, domain=domain)
        yield await stack.enter_async_context(system)


@asynccontextmanager
async def connect_system(options: RosOptions) -> AsyncIterator[RosSystem]:
    """Connect to a ROS 2 system for the duration of the block.

    Raises:
        UsageError: The definitions are unreadable, or the dialect is unknown.
        BackendError: The endpoint is unreachable, or no ROS 2 system was found.
    """
    types = await anyio.to_thread.run_sync(TypeStore.bundled, options.distribution, options.interfaces)
    dialect = wire.named_dialect(options.dialect, options.domain)
    async with connect(options.endpoint, types=types, dialect=dialect, domain=options.domain) as system:
        yield system
