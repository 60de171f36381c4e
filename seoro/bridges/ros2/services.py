"""Calling and serving services of a ROS 2 system."""

from __future__ import annotations

import itertools
import time
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

import anyio

from seoro.bridges.ros2.agreement import agree
from seoro.bridges.ros2.errors import NoResponse, NoServiceServer, ServerFailed, SystemLost
from seoro.bridges.ros2.graph import RosGraph
from seoro.bridges.ros2.interfaces import Message, TypeStore
from seoro.bridges.ros2.wire import Attachment, Dialect, InvalidAttachment
from seoro.bridges.session import AsyncSession, Bound, Mailbox, NoAnswer, NoServer, Refused, Request
from seoro.errors import SeoroError

Handler = Callable[[Message], Awaitable[Mapping[str, Any] | Message]]

WAITING = Bound(64, lose="newest")  # requests that no handler has begun with
AT_ONCE = 256  # handlers of one server; those of an action wait for as long as its goals take
BUSY = b"the server has too many requests"
GOING = b"the server is ending"
LOSS_NOTICE = 0.2  # [s] after a server has gone, until the session has noticed that its router has
FOREVER = 1e7  # [s], a call without a timeout: Zenoh wants a number


class Client:
    """A client of a service. Made by `RosNode.calling`.

    Attributes:
        service: Full name.
        type: Full name of the type of the service.
    """

    def __init__(
        self, service: str, type_name: str, session: AsyncSession, graph: RosGraph, gid: bytes, types: TypeStore
    ) -> None:
        self.service = service
        self.type = type_name
        self._session = session
        self._graph = graph
        self._gid = gid
        self._types = types
        self._numbers = itertools.count(1)

    async def wait_for_server(self, timeout: float | None = None) -> None:
        """Wait until somebody serves it.

        Args:
            timeout: [s] of the machine's clock; without end when None.

        Raises:
            NoServiceServer: Nobody did in time.
        """
        try:
            await self._graph.wait_for(lambda graph: graph.servers(self.service), timeout)
        except TimeoutError:
            await self._check_connected()
            raise NoServiceServer(f"nobody serves {self.service} after {timeout:g} s") from None

    async def call(self, request: Mapping[str, Any] | Message, timeout: float | None = None) -> Message:
        """Call the service; if the call is cancelled, a response that comes later is dropped.

        Args:
            request: The request; missing members have the defaults of the definition.
            timeout: [s] of the machine's clock until the response has to be there; without end when None.

        Raises:
            InvalidValue: It is no request of this type.
            NoServiceServer: Nobody serves it at this time.
            WrongType, DefinitionMismatch: It is not the service that was meant.
            NoResponse: The server took too long, or went away.
            SystemLost: There is no connection to the ROS 2 system.
            ServerFailed: The server said that it could not respond.
            InvalidPayload: The response is not of this type.
        """
        servers = self._graph.servers(self.service)
        if not servers:
            await self._check_connected()
            raise NoServiceServer(f"nobody serves {self.service}")
        dialect = self._graph.dialect
        type_hash, types = agree(self.service, self.type, servers, self._types)
        key = dialect.key(self.service, self.type, type_hash)
        payload = types.encode(f"{self.type}_Request", request)
        attachment = dialect.attachment(next(self._numbers), time.time_ns(), self._gid)
        limit = FOREVER if timeout is None else timeout
        try:
            response = await self._session.query(key, payload, limit, attachment)
        except NoAnswer:
            await self._check_connected()
            raise NoResponse(f"{self.service} has not responded within {limit:g} s") from None
        except NoServer:
            await self._check_connected(LOSS_NOTICE)
            raise NoResponse(f"the server of {self.service} went away, or dropped the request") from None
        except Refused as refusal:
            reason = refusal.payload.decode(errors="replace")
            raise ServerFailed(f"the server of {self.service} failed: {reason}") from None
        return types.decode(f"{self.type}_Response", response)

    async def _check_connected(self, within: float = 0.0) -> None:
        """Raise `SystemLost` if it is the connection that is lost, or is found to be within a time [s]."""
        deadline = time.monotonic() + within
        while not self._session.is_cut_off:
            if time.monotonic() >= deadline:
                return
            await anyio.sleep(LOSS_NOTICE / 10)
        what = f"the connection to the ROS 2 system is lost: {self.service} cannot be called"
        raise SystemLost(what) from None


class Server:
    """Responds to the requests of a service: each by a task of its own.

    Args:
        type_name: Full name of the type of the service.
        handler: Gets requests and returns responses, whose missing members have the defaults of the definition.
            When it raises an error of seoro's, the client gets that as an error; anything else is a defect and
            ends the server.
        dialect: How the system talks.
        types: Definitions of the types.
    """

    def __init__(self, type_name: str, handler: Handler, dialect: Dialect, types: TypeStore) -> None:
        self._type = type_name
        self._handler = handler
        self._dialect = dialect
        self._types = types

    async def run(self, requests: Mailbox[Request]) -> None:
        """Respond until there are no more requests."""
        room = anyio.Semaphore(AT_ONCE)
        async with anyio.create_task_group() as tasks:
            async for request in requests:
                await room.acquire()
                tasks.start_soon(self._respond, request, room)

    async def _respond(self, request: Request, room: anyio.Semaphore) -> None:
        try:
            response = self._types.encode(f"{self._type}_Response", await self._handler(self._read(request)))
        except SeoroError as error:
            request.refuse(str(error).encode())
        except BaseException:
            request.refuse(GOING)
            raise
        else:
            request.reply(response, self._attachment(request))
        finally:
            room.release()

    def _read(self, request: Request) -> Message:
        if not request.payload:  # the bridge for DDS allows for requests without anything in them
            return self._types.message(f"{self._type}_Request", {})
        return self._types.decode(f"{self._type}_Request", request.payload)

    def _attachment(self, request: Request) -> bytes | None:
        """That of a response: number and sender are those of the request."""
        try:
            asked = Attachment.parse(request.attachment)
        except InvalidAttachment:
            return None
        return self._dialect.attachment(asked.sequence, time.time_ns(), asked.gid)
