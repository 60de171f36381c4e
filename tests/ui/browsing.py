"""Requests to a served site, as a browser that has opened its URL sends them."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import httpx
from websockets.sync.client import ClientConnection, connect

from seoro.ui.security import Access
from tests.report.joining import split

DEADLINE = 60.0  # [s], on a busy machine


class Browser:
    """A browser that has opened the URL of a site."""

    def __init__(self, access: Access, http: httpx.Client) -> None:
        self.access = access
        self.origin = str(http.base_url).rstrip("/")
        self.http = http

    @property
    def cookie(self) -> str:
        return "; ".join(f"{name}={value}" for name, value in self.http.cookies.items())

    def get(self, path: str) -> Any:
        """Return the JSON data of a path."""
        return self.http.get(path).raise_for_status().json()

    def wait_for(self, path: str, fits: Callable[[Any], bool]) -> Any:
        """Wait until the JSON data of a path fits."""
        end = time.monotonic() + DEADLINE
        while not fits(found := self.get(path)):
            assert time.monotonic() < end, found
            time.sleep(0.05)
        return found

    def frame(self, socket: ClientConnection) -> dict[str, Any]:
        """Return the JSON data of the next frame of a run."""
        return next_frame(socket)[0]

    def post(self, path: str, data: object = None) -> httpx.Response:
        return self.http.post(path, json=data, headers={"Origin": self.origin})

    @contextmanager
    def socket(self, path: str, max_queue: int = 16, **headers: str) -> Iterator[ClientConnection]:
        url = self.origin.replace("http", "ws", 1) + path
        more = {"Cookie": self.cookie, "Origin": self.origin, **headers}
        with connect(
            url,
            additional_headers=more,
            max_size=None,
            max_queue=max_queue,
            open_timeout=DEADLINE,
            proxy=None,
        ) as opened:
            yield opened

    def run(self, fits: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """Wait for a run in the list."""
        runs: dict[str, dict[str, Any]] = {}
        with self.socket("/api/runs") as socket:
            while True:
                message = json.loads(socket.recv(DEADLINE))
                runs |= {run["id"]: run for run in message.get("runs", message.get("changed"))}
                for name in message.get("removed", ()):
                    del runs[name]
                for run in runs.values():
                    if fits(run):
                        return run


@contextmanager
def opened(access: Access) -> Iterator[Browser]:
    """Open the URL of a site."""
    with httpx.Client(base_url=access.url.partition("/?")[0], timeout=DEADLINE) as client:
        assert client.get(access.url).status_code == 303
        yield Browser(access, client)


def read_frame(socket: ClientConnection) -> tuple[dict[str, Any], bytes]:
    """Return the JSON data and the columns of the next frame of a run."""
    pieces = bytearray()
    while True:
        piece = socket.recv(DEADLINE)
        assert isinstance(piece, bytes)
        pieces += piece[1:]
        if not piece[0]:
            return split(bytes(pieces))
        socket.send("next")


def next_frame(socket: ClientConnection) -> tuple[dict[str, Any], bytes]:
    """Return the next frame of a run, and request the one after it."""
    found = read_frame(socket)
    socket.send("next")
    return found
