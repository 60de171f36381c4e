"""Clients and servers of ROS 2 services."""

from __future__ import annotations

import itertools
import time
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import anyio

from seoro.bridges.ros2.errors import NoResponse, NoServiceServer, ServerFailed, SystemLost
from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.interfaces import Message, TypeStore
from seoro.bridges.ros2.type_matching import match_types
from seoro.bridges.ros2.wire import Attachment, Dialect
from seoro.bridges.session import AsyncSession, Bound, Mailbox, NoAnswer, NoServer, Refused, Request
from seoro.errors import SeoroError

Handler = Callable[[Message], Awaitable[Mapping[str, Any] | Message]]

WAITING = Bound(64, drop="newest")  # queue of requests
MAX_HANDLERS = 256  # running handlers of one server; those of an action run as long as its goals
BUSY = b"the server has too many requests"
STOPPING = b"the server is stopping"
LOSS_DETECTION = 0.2  # [s] from the loss of a server until the session notices the loss of its router
FOREVER = 1e7  # [s]; timeout of calls without a timeout, since Zenoh requires a number


@dataclass(eq=False)
class Client:
    """Client of a service. Made by `RosNode.calling`.

    Attributes:
        service: Full name of the service.
        type: Full name of the type of the service.
    """

    service: str
    type: str
    _session: AsyncSession
    _graph: RosGraph
    _gid: bytes
    _types: TypeStore
    _numbers: itertools.count[int] = field(default_factory=lambda: itertools.count(1))

    async def wait_for_server(self, timeout: float | None = None) -> None:
        """Wait for a server of the service.

        Args:
            timeout: Time limit [s] of the machine's clock; None for no limit.

        Raises:
            NoServiceServer: No server appeared in time.
        """
        try:
            await self._graph.wait_for(lambda graph: graph.servers(self.service), timeout)
        except TimeoutError:
            await self._check_connected()
            raise NoServiceServer(f"no server of {self.service} within {timeout:g} s") from None

    async def call(self, request: Mapping[str, Any] | Message, timeout: float | None = None) -> Message:
        """Call the service; a response after a cancelled call is dropped.

        Args:
            request: The request; missing members have the defaults of the definition.
            timeout: Time limit [s] of the response, by the machine's clock; None for no limit.

        Raises:
            InvalidValue: The request does not fit the type.
            NoServiceServer: The service has no server now.
            WrongType, DefinitionMismatch: The service has another type, or another definition of it.
            NoResponse: The server took too long, or disappeared.
            SystemLost: The connection to the ROS 2 system is lost.
            ServerFailed: The server reported a failure.
            InvalidPayload: The response is not a message of the type.
        """
        servers = self._graph.servers(self.service)
        if not servers:
            await self._check_connected()
            raise NoServiceServer(f"no server of {self.service}")
        dialect = self._graph.dialect
        type_hash, types = match_types(self.service, self.type, servers, self._types)
        key = dialect.key(self.service, self.type, type_hash)
        payload = types.encode(f"{self.type}_Request", request)
        attachment = dialect.attachment(next(self._numbers), time.time_ns(), self._gid)
        limit = FOREVER if timeout is None else timeout
        try:
            response = await self._session.query(key, payload, limit, attachment)
        except NoAnswer:
            await self._check_connected()
            raise NoResponse(f"no response from {self.service} within {limit:g} s") from None
        except NoServer:
            await self._check_connected(LOSS_DETECTION)
            raise NoResponse(f"the server of {self.service} disappeared, or dropped the request") from None
        except Refused as refusal:
            reason = refusal.payload.decode(errors="replace")
            raise ServerFailed(f"the server of {self.service} failed: {reason}") from None
        return types.decode(f"{self.type}_Response", response)

    def server_types(self) -> TypeStore:
        """Return the definitions of the servers of the service; those of seoro without servers.

        Raises:
            WrongType, DefinitionMismatch: The service has another type, or another definition of it.
        """
        return match_types(self.service, self.type, self._graph.servers(self.service), self._types)[1]

    async def _check_connected(self, within: float = 0.0) -> None:
        """Raise `SystemLost` if the loss of the connection is known, or is noticed within a time [s]."""
        deadline = time.monotonic() + within
        while not self._session.is_cut_off:
            if time.monotonic() >= deadline:
                return
            await anyio.sleep(LOSS_DETECTION / 10)
        message = f"the connection to the ROS 2 system is lost: {self.service} cannot be called"
        raise SystemLost(message) from None


@dataclass(eq=False)
class Server:
    """Server of a service, with one task per request.

    Args:
        type_name: Full name of the type of the service.
        handler: Returns the response to a request; missing members have the defaults of the definition. A
            `SeoroError` is sent to the client. Any other exception is a defect and ends the server.
        dialect: Dialect of the system.
        types: Definitions of the types.
    """

    type_name: str
    handler: Handler
    dialect: Dialect
    types: TypeStore

    async def run(self, requests: Mailbox[Request]) -> None:
        """Respond to requests until their queue is closed."""
        free = anyio.Semaphore(MAX_HANDLERS)
        async with anyio.create_task_group() as tasks:
            async for request in requests:
                await free.acquire()
                tasks.start_soon(self._respond, request, free)

    async def _respond(self, request: Request, free: anyio.Semaphore) -> None:
        try:
            response = self.types.encode(f"{self.type_name}_Response", await self.handler(self._read(request)))
        except SeoroError as error:
            request.refuse(str(error).encode())
        except BaseException:
            request.refuse(STOPPING)
            raise
        else:
            request.reply(response, self._attachment(request))
        finally:
            free.release()

    def _read(self, request: Request) -> Message:
        if not request.payload:  # the bridge for DDS allows empty requests
            return self.types.message(f"{self.type_name}_Request", {})
        return self.types.decode(f"{self.type_name}_Request", request.payload)

    def _attachment(self, request: Request) -> bytes | None:
        """Return the attachment of a response, with the sequence number and sender of the request."""
        received = Attachment.parse(request.attachment)
        if received is None:
            return None
        return self.dialect.attachment(received.sequence, time.time_ns(), received.gid)


def simulation_service_type(name: str) -> str:
    """Return the type of a service of `simulation_interfaces`, such as `GetEntities` of `get_entities`."""
    return f"simulation_interfaces/srv/{name.title().replace('_', '')}"
