"""WebSockets that send data while a page shows it."""

from __future__ import annotations

from collections.abc import AsyncGenerator, Mapping
from contextlib import aclosing
from typing import Any, Final, TypeAlias

import anyio
from starlette.websockets import WebSocket, WebSocketDisconnect

from seoro.errors import SeoroError
from seoro.runtime.trace.jsonl import to_json
from seoro.ui.answers import RequestError, as_request_error

LARGEST_MESSAGE: Final = 64 << 10  # [bytes] from a page
_FAILED: Final = 4000  # close code of pages' errors: that of HTTP is added
_REASON: Final = 120  # [bytes]

Data: TypeAlias = bytes | Mapping[str, Any]


async def send_all(socket: WebSocket, parts: AsyncGenerator[Data, None], *, on_request: bool = False) -> None:
    """Send data until it ends or the page closes the socket.

    Args:
        socket: The WebSocket.
        parts: Binary frames, and objects that are sent as JSON. It receives no request while the page is slow.
            An error is sent as an object with `error` and `help`, and
            closes the socket.
        on_request: Whether each part but the first waits for a message of the page: it requests the next one.
    """
    await socket.accept()
    requests = anyio.Semaphore(0)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(_receive, socket, requests, tasks.cancel_scope)
        try:
            async with aclosing(parts):
                async for part in parts:
                    await _send(socket, part)
                    if on_request:
                        await requests.acquire()
        except (RequestError, SeoroError) as error:
            found = as_request_error(error)
            await _send(socket, found.data)
            await socket.close(_FAILED + found.status, _shortened(found.error))
        except WebSocketDisconnect:
            pass
        tasks.cancel_scope.cancel()


async def _send(socket: WebSocket, part: Data) -> None:
    if isinstance(part, bytes):
        await socket.send_bytes(part)
    else:
        await socket.send_text(to_json(part).encode("utf-8", "replace").decode())


async def _receive(socket: WebSocket, requests: anyio.Semaphore, scope: anyio.CancelScope) -> None:
    """Count the messages of the page, until it closes the socket."""
    while (await socket.receive())["type"] != "websocket.disconnect":
        requests.release()
    scope.cancel()


def _shortened(reason: str) -> str:
    """Shorten the reason of a close, which has at most 123 bytes."""
    return reason.encode("utf-8", "replace")[:_REASON].decode("utf-8", "ignore")
