"""Messages of the Debug Adapter Protocol: JSON with a header, as in HTTP."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Mapping
from contextlib import suppress
from itertools import count
from typing import Any, Final, Protocol

MAX_HEADER: Final = 4096  # [bytes]
MAX_BODY: Final = 16 * 1024 * 1024  # [bytes]
_LENGTH: Final = b"content-length:"


class InvalidMessage(Exception):
    """The other side does not follow the protocol; the connection ends."""


class Writer(Protocol):
    """Stream of own messages, such as `asyncio.StreamWriter`."""

    def write(self, data: bytes, /) -> None:
        """Write data, or keep them to be written."""

    async def drain(self) -> None:
        """Wait until there is room for more."""


class Connection:
    """Connection with one editor.

    Args:
        reader: Stream of the editor's messages.
        writer: Stream for own messages.
    """

    def __init__(self, reader: asyncio.StreamReader, writer: Writer) -> None:
        self._reader = reader
        self._writer = writer
        self._numbers = count(1)

    async def receive(self) -> dict[str, Any] | None:
        """Return the next message; None when the editor has closed the connection.

        Raises:
            InvalidMessage: It is not a message.
        """
        length: int | None = None
        size = 0
        while line := await self._line():
            size += len(line)
            if size > MAX_HEADER:
                raise InvalidMessage(f"a header has more than {MAX_HEADER} bytes")
            if not line.strip():
                if length is not None:
                    return await self._body(length)
                continue
            if line.lower().startswith(_LENGTH):
                length = _length(line[len(_LENGTH) :])
        return None

    async def _line(self) -> bytes:
        try:
            return await self._reader.readline()
        except ValueError as error:  # longer than the buffer of the stream
            raise InvalidMessage(f"a header has more than {MAX_HEADER} bytes") from error

    async def _body(self, length: int) -> dict[str, Any] | None:
        try:
            found = json.loads(await self._reader.readexactly(length))
        except asyncio.IncompleteReadError:
            return None
        except (ValueError, RecursionError) as error:
            raise InvalidMessage("a message is not valid JSON") from error
        if not isinstance(found, dict):
            raise InvalidMessage("a message is not a JSON object")
        return found

    def event(self, name: str, body: Mapping[str, Any] | None = None) -> None:
        """Send an event."""
        self._send({"type": "event", "event": name, "body": body or {}})

    def answer(self, request: Mapping[str, Any], body: Mapping[str, Any] | None = None) -> None:
        """Answer a request."""
        self._send({**_answer_to(request), "success": True, "body": body or {}})

    def refuse(self, request: Mapping[str, Any], message: str) -> None:
        """Refuse a request; the editor shows the message."""
        error = {"id": 1, "format": "{text}", "variables": {"text": message}, "showUser": True}
        self._send({**_answer_to(request), "success": False, "message": message, "body": {"error": error}})

    async def drain(self) -> None:
        """Wait until sent messages are written; a closed connection is not an error."""
        with suppress(ConnectionError):
            await self._writer.drain()

    def _send(self, message: dict[str, Any]) -> None:
        self._writer.write(encode({"seq": next(self._numbers), **message}))


def encode(message: Mapping[str, Any]) -> bytes:
    """Encode a message with its header."""
    data = json.dumps(message).encode()
    return b"Content-Length: %d\r\n\r\n%s" % (len(data), data)


def _answer_to(request: Mapping[str, Any]) -> dict[str, Any]:
    return {"type": "response", "request_seq": request.get("seq", 0), "command": request.get("command", "")}


def _length(text: bytes) -> int:
    try:
        length = int(text)
    except ValueError:
        length = -1
    if not 0 <= length <= MAX_BODY:
        raise InvalidMessage(f"invalid Content-Length; expected 0 to {MAX_BODY}")
    return length
