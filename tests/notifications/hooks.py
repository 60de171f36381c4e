"""A local HTTP server that receives notifications."""

from __future__ import annotations

import json
import ssl
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Event, Thread
from typing import Any


@dataclass
class Hook:
    """A server.

    Args:
        statuses: Statuses of its answers in order; the last one stays.
        is_slow: Whether it never answers.
        certificate: File with its key and certificate, for HTTPS.
    """

    statuses: Sequence[int] = (204,)
    is_slow: bool = False
    certificate: Path | None = None
    url: str = ""
    paths: list[str] = field(default_factory=list)
    headers: list[dict[str, str]] = field(default_factory=list)
    bodies: list[bytes] = field(default_factory=list)
    ended: Event = field(default_factory=Event)

    @property
    def messages(self) -> list[dict[str, Any]]:
        """The received notifications."""
        return [json.loads(body) for body in self.bodies]


@contextmanager
def hooked(hook: Hook) -> Iterator[Hook]:
    """Serve while the block lasts."""

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            hook.bodies.append(self.rfile.read(int(self.headers["Content-Length"])))
            hook.headers.append(dict(self.headers))
            hook.paths.append(self.path)
            if hook.is_slow:
                hook.ended.wait()
                return
            self.send_response(hook.statuses[min(len(hook.bodies), len(hook.statuses)) - 1])
            self.send_header("Location", "/elsewhere")
            self.send_header("Content-Length", "0")
            self.end_headers()

        do_GET = do_POST  # noqa: N815 - the name of the base class

        def log_message(self, *_: Any) -> None:
            """Print nothing."""

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    if hook.certificate is not None:
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(hook.certificate)
        server.socket = context.wrap_socket(server.socket, server_side=True)
    thread = Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    hook.url = f"http{'s' if hook.certificate else ''}://127.0.0.1:{server.server_port}/hook?token=hidden"
    try:
        yield hook
    finally:
        hook.ended.set()
        server.shutdown()
        server.server_close()
        thread.join()
