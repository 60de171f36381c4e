"""Taking part in a ROS 2 system: nodes that publish, subscribe, call and serve.

Everything is a context: it is announced when the block begins and is gone when it ends, on every path.
"""

from __future__ import annotations

import itertools
from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field

from seoro.background import background
from seoro.bridges.ros2.addresses import ROUTER
from seoro.bridges.ros2.agreement import agree, announced_hash, check_type, meeting_hash
from seoro.bridges.ros2.errors import NoSystem
from seoro.bridges.ros2.graph import RosGraph, find_graph, open_graph
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.services import BUSY, WAITING, Client, Handler, Server
from seoro.bridges.ros2.topics import ALL, Publication, Subscription
from seoro.bridges.ros2.wire import (
    PRESETS,
    Dialect,
    Endpoint,
    History,
    Kind,
    Node,
    Qos,
    check_node_name,
    resolve,
    resolve_namespace,
)
from seoro.bridges.session import (
    AsyncSession,
    Bound,
    InvalidEndpoint,
    SessionError,
    open_session,
    publishing,
    subscribing,
)
from seoro.errors import InvalidUse

DISCOVERY_TIMEOUT = 3.0  # [s] until something of a system has to be seen
SERVICE_QOS = PRESETS["services_default"]


@dataclass(frozen=True)
class RosSystem:
    """A ROS 2 system that is reached. Made by `open_system`.

    Attributes:
        session: Session over which it is reached.
        graph: What there is in it.
        types: The definitions that seoro has.
    """

    session: AsyncSession
    graph: RosGraph
    types: TypeStore
    _numbers: itertools.count[int] = field(default_factory=itertools.count, repr=False)

    @property
    def dialect(self) -> Dialect:
        """How it uses Zenoh."""
        return self.graph.dialect

    @asynccontextmanager
    async def node(self, name: str = "seoro", namespace: str = "/") -> AsyncIterator[RosNode]:
        """Be a node of the system for as long as the block lasts.

        Raises:
            InvalidName: Nodes or namespaces cannot be called that.
        """
        node = Node(
            self.session.identity, next(self._numbers), check_node_name(name), resolve_namespace(namespace)
        )
        token = self.dialect.token(node)
        if token is None:
            yield RosNode(self, node)
            return
        async with self.session.token(token):
            yield RosNode(self, node)

    def number(self) -> int:
        """A number for a node or endpoint, which none has had yet."""
        return next(self._numbers)


@dataclass(frozen=True)
class RosNode:
    """A node of seoro's. Made by `RosSystem.node`.

    Names of topics and services may be relative to its namespace, or private (`~/name`).
    """

    system: RosSystem
    node: Node

    @property
    def graph(self) -> RosGraph:
        """What there is in the system."""
        return self.system.graph

    def resolve(self, name: str) -> str:
        """The full name of a topic, service or action.

        Raises:
            InvalidName: It is none.
        """
        return resolve(name, self.node.namespace, self.node.name)

    @asynccontextmanager
    async def publishing(
        self, topic: str, type_name: str, qos: Qos | None = None, *, type_hash: str | None = None
    ) -> AsyncIterator[Publication]:
        """Be a publisher of a topic for as long as the block lasts.

        Args:
            topic: Its name.
            type_name: Type of the messages.
            qos: What is offered; reliable, volatile, with a depth of 10 when None.
            type_hash: Of the definition by which the messages are CDR already (`Publication.send`), which seoro
                need not have; None for definitions that it has.

        Raises:
            InvalidName, UnknownInterface: There is no such name or type.
            WrongType, DefinitionMismatch: Those who subscribe mean something else.
        """
        system, offered = self.system, qos or Qos()
        topic, types = self.resolve(topic), system.types
        others = self._others(self.graph.subscriptions(topic))
        if type_hash is None:
            type_name = types.canonical(type_name)
            type_hash, types = agree(topic, type_name, others, types)
        else:
            type_hash = meeting_hash(topic, type_name, others, type_hash)
        check_type(topic, type_name, self._others(self.graph.publishers(topic)))
        endpoint = self._endpoint(Kind.PUBLISHER, topic, type_name, type_hash, offered)
        token = self._token(endpoint)
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
                    meeting_hash(topic, type_name, self._others(self.graph.subscriptions(topic)), type_hash)

            gid = system.dialect.gid(token)
            yield Publication(topic, type_name, offered, publisher, system.dialect, gid, types, check)

    @asynccontextmanager
    async def subscribing(
        self,
        topic: str,
        type_name: str,
        qos: Qos | None = None,
        bound: Bound | None = None,
        *,
        is_decoded: bool = True,
        is_checked: bool = True,
    ) -> AsyncIterator[Subscription]:
        """Be a subscription of a topic for as long as the block lasts.

        Args:
            topic: Its name.
            type_name: Type of the messages. If seoro has no definition of it, they can be received, not decoded.
            qos: What is asked for; reliable, volatile, with a depth of 10 when None.
            bound: How many messages wait to be taken, and which are lost of more; by the QoS when None.
            is_decoded: Whether messages will be; what that needs is prepared before the first one comes.
            is_checked: Whether it is an error that all who publish have another type; if not, they are not heard.

        Raises:
            InvalidName: There is no such name.
            WrongType: The topic has another type.
        """
        system, asked = self.system, qos or Qos()
        topic = self.resolve(topic)
        publishers = self._others(self.graph.publishers(topic))
        if type_name not in {publisher.type for publisher in publishers}:
            type_name = system.types.canonical(type_name)
        if is_checked:
            check_type(topic, type_name, publishers)
        if is_decoded and type_name in system.types.names():
            system.types.prepare(type_name)
        endpoint = self._endpoint(
            Kind.SUBSCRIPTION, topic, type_name, announced_hash(type_name, publishers, system.types), asked
        )
        history = asked.depth if asked.is_transient_local else 0
        if bound is None:
            bound = ALL if asked.history is History.KEEP_ALL else Bound(asked.depth)
        key = system.dialect.every_key(topic, type_name)
        subscription = Subscription(topic, type_name, bound, system.dialect, system.types)
        take_in, recover = subscription.take_in, asked.is_reliable
        # The token comes first: publishers of large messages look for it before they choose the key.
        async with (
            system.session.token(self._token(endpoint)),
            subscribing(system.session, key, take_in, history=history, recover=recover),
        ):
            try:
                yield subscription
            finally:
                subscription.close()

    @asynccontextmanager
    async def calling(self, service: str, type_name: str) -> AsyncIterator[Client]:
        """Be a client of a service for as long as the block lasts.

        Raises:
            InvalidName, UnknownInterface: There is no such name or type.
        """
        system = self.system
        service, type_name = self.resolve(service), system.types.canonical(type_name)
        type_hash = announced_hash(type_name, self.graph.servers(service), system.types)
        token = self._token(self._endpoint(Kind.CLIENT, service, type_name, type_hash, SERVICE_QOS))
        async with system.session.token(token):
            yield Client(service, type_name, system.session, self.graph, system.dialect.gid(token), system.types)

    @asynccontextmanager
    async def serving(self, service: str, type_name: str, handler: Handler) -> AsyncIterator[None]:
        """Serve a service for as long as the block lasts.

        Args:
            service: Its name.
            type_name: Its type.
            handler: Responds to requests; see `Server`.

        Raises:
            InvalidName, UnknownInterface: There is no such name or type.
        """
        system = self.system
        service, type_name = self.resolve(service), system.types.canonical(type_name)
        type_hash = system.types.type_hash(type_name)
        token = self._token(self._endpoint(Kind.SERVER, service, type_name, type_hash, SERVICE_QOS))
        key = system.dialect.key(service, type_name, type_hash)
        server = Server(type_name, handler, system.dialect, system.types)
        async with (
            system.session.answering(key, WAITING, BUSY) as requests,
            system.session.token(token),
            background() as tasks,
        ):
            tasks.start_soon(server.run, requests)
            yield

    def _others(self, endpoints: Sequence[Endpoint]) -> tuple[Endpoint, ...]:
        """Those that are not seoro's own."""
        return tuple(each for each in endpoints if each.session != self.node.session)

    def _endpoint(self, kind: Kind, name: str, type_name: str, type_hash: str | None, qos: Qos) -> Endpoint:
        session, number = self.system.session.identity, self.system.number()
        return Endpoint(kind, name, type_name, session, type_hash, qos, number, self.node)

    def _token(self, endpoint: Endpoint) -> str:
        token = self.system.dialect.token(endpoint)
        assert token is not None, "topics and services are announced in all dialects"
        return token


@asynccontextmanager
async def open_system(
    session: AsyncSession, types: TypeStore, *, dialect: Dialect | None = None, domain: int = 0
) -> AsyncIterator[RosSystem]:
    """Take part in the ROS 2 system that a session reaches.

    Args:
        session: Session that is connected to the robot's router, or to its bridge.
        types: Definitions of types.
        dialect: How it uses Zenoh; found out when None.
        domain: Where to look when it has to be found out (ROS_DOMAIN_ID).

    Raises:
        NoSystem: Nothing is seen.
        InvalidUse: Both dialects are seen.
    """
    following = find_graph(session, domain, DISCOVERY_TIMEOUT) if dialect is None else open_graph(session, dialect)
    async with following as graph:
        yield RosSystem(session, graph, types)


@asynccontextmanager
async def connect(
    endpoint: str = ROUTER, *, types: TypeStore | None = None, dialect: Dialect | None = None, domain: int = 0
) -> AsyncIterator[RosSystem]:
    """Reach the ROS 2 system behind a router; see `open_system`.

    Args:
        endpoint: Zenoh endpoint of the router that the robot's nodes use, or of the bridge; by default on this
            machine.
        types: Definitions of types; by default those that come with seoro.
        dialect: How the system uses Zenoh; found out when None.
        domain: Where to look when it has to be found out (ROS_DOMAIN_ID).

    Raises:
        NoSystem: Nobody listens there, or nothing is seen.
        InvalidUse: It is no endpoint, or both dialects are seen.
    """
    async with AsyncExitStack() as stack:
        try:
            session = await stack.enter_async_context(open_session(connect=endpoint, patient=False))
        except InvalidEndpoint as error:
            raise InvalidUse(str(error)) from None
        except SessionError as error:
            raise NoSystem(f"cannot connect to {endpoint}: no router and no bridge answers there") from error
        system = open_system(session, types or TypeStore.bundled(), dialect=dialect, domain=domain)
        yield await stack.enter_async_context(system)
