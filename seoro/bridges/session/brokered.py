"""Connections of a process in a sandbox: by a broker outside, which has the keys and the connections.

Where there is a broker, sessions connect to sockets that it makes for them, and commands are signed by it. It is
asked over a socket, each by `[verb, argument]`; an answer is `[whether it was done, value, help]`.
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
REACH: Final = "reach"  # an endpoint: a socket file that leads there
SIGN: Final = "sign"  # bytes: their signature
CREDENTIALS: Final = "credentials"  # PEM: certificates of the authority and the own one, revoked.crl
_SOCKET: Final = "unixsock-stream/"


class Broker:
    """The broker of this process; for any thread.

    Args:
        connection: To it.
    """

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self._lock = threading.Lock()

    def ask(self, verb: str, argument: Any) -> Any:
        """Return the answer of the broker.

        Raises:
            SessionError: It refuses, or is gone.
        """
        asked = msgpack.packb([verb, argument])
        with self._lock:
            try:
                self._connection.sendall(LENGTH.pack(len(asked)) + asked)
                [length] = LENGTH.unpack(self._read(LENGTH.size))
                is_done, value, advice = msgpack.unpackb(self._read(length))
            except OSError as error:
                raise SessionError("the broker of the sandbox is gone") from error
        if not is_done:
            raise SessionError(f"{value}{advice and f' ({advice})'}")
        return value

    def _read(self, length: int) -> bytes:
        found = b""
        while len(found) < length:
            if not (part := self._connection.recv(length - len(found))):
                raise ConnectionResetError
            found += part
        return found


_broker: Broker | None = None


def use(broker: Broker) -> None:
    """Have all sessions of this process go by a broker."""
    global _broker  # noqa: PLW0603 - the process is in a sandbox, or it is not
    _broker = broker


def broker_here() -> Broker | None:
    """The broker of this process; None outside of sandboxes."""
    return _broker


def reached(endpoint: str) -> str:
    """Return the address to which a session of this process connects to reach an endpoint.

    Raises:
        SessionError: It cannot be reached.
    """
    is_here = endpoint.startswith(_SOCKET) and Path(endpoint.removeprefix(_SOCKET)).exists()
    if _broker is None or is_here:
        return endpoint
    return f"{_SOCKET}{_broker.ask(REACH, endpoint)}"
