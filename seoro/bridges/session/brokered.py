"""Connections of a sandboxed process, by a broker outside the sandbox that has the keys and the connections.

Sessions connect to sockets of the broker, which signs their commands. Requests to the broker are `[verb,
argument]` over a socket; an answer is `[success, value, help]`.
"""

from __future__ import annotations

import socket
import struct
import threading
from pathlib import Path
from typing import Any, Final

import msgpack

from seoro.bridges.session.errors import SessionError

LENGTH: Final = struct.Struct("!I")
REACH: Final = "reach"  # argument: endpoint; answer: socket file that is connected to it
SIGN: Final = "sign"  # argument: bytes; answer: their signature
CREDENTIALS: Final = "credentials"  # answer, as PEM: certificates of the authority and of the run, revoked.crl
_SOCKET: Final = "unixsock-stream/"


class Broker:
    """Client of the broker of this process; for any thread.

    Args:
        connection: Connection to the broker.
    """

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self._lock = threading.Lock()

    def ask(self, verb: str, argument: Any) -> Any:
        """Return the answer of the broker.

        Raises:
            SessionError: The broker rejects the request, or is disconnected.
        """
        request = msgpack.packb([verb, argument])
        with self._lock:
            try:
                self._connection.sendall(LENGTH.pack(len(request)) + request)
                [length] = LENGTH.unpack(self._read(LENGTH.size))
                is_done, value, advice = msgpack.unpackb(self._read(length))
            except OSError as error:
                raise SessionError("the broker of the sandbox is disconnected") from error
        if not is_done:
            raise SessionError(f"{value}{advice and f' ({advice})'}")
        return value

    def _read(self, length: int) -> bytes:
        data = b""
        while len(data) < length:
            if not (part := self._connection.recv(length - len(data))):
                raise ConnectionResetError
            data += part
        return data


_broker: Broker | None = None


def use_broker(broker: Broker) -> None:
    """Connect all later sessions of this process by a broker."""
    global _broker  # noqa: PLW0603 - a process is sandboxed as a whole
    _broker = broker


def current_broker() -> Broker | None:
    """Return the broker of this process; None outside sandboxes."""
    return _broker


def broker_address(endpoint: str) -> str:
    """Return the address to which a session of this process connects to reach an endpoint.

    Raises:
        SessionError: The endpoint cannot be reached.
    """
    is_inside = endpoint.startswith(_SOCKET) and Path(endpoint.removeprefix(_SOCKET)).exists()
    if _broker is None or is_inside:
        return endpoint
    return f"{_SOCKET}{_broker.ask(REACH, endpoint)}"
