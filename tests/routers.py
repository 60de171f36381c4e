"""Routers of Zenoh for tests, and processes that reach them."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from typing import IO

from seoro.bridges.session import Session

_ROUTER = """
import sys, time
from seoro.bridges.session import Session
session = Session(listen=sys.argv[1], gossip=True)
print("ready", flush=True)
time.sleep(3600)
"""


def free_endpoint() -> str:
    """Return an unused endpoint."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


def as_if_elsewhere(endpoint: str) -> str:
    """Return an endpoint that leads to the same router as if it were on another machine, without direct links."""
    return endpoint.replace("127.0.0.1", "0.0.0.0")


@contextmanager
def routing() -> Iterator[str]:
    """Start a router like rmw_zenohd, and yield its endpoint."""
    endpoint = free_endpoint()
    hub = Session(listen=endpoint, gossip=True)
    try:
        yield endpoint
    finally:
        hub.close()


@contextmanager
def process(
    *command: str,
    says: str | None = "ready",
    stderr: IO[bytes] | None = None,
    environment: Mapping[str, str] | None = None,
) -> Iterator[subprocess.Popen[bytes]]:
    """Start a Python process, and wait for its first line.

    `says` is the expected line, or None for any. `environment` has additional variables.
    """
    own = None if environment is None else {**os.environ, **environment}
    with subprocess.Popen([sys.executable, *command], stdout=subprocess.PIPE, stderr=stderr, env=own) as running:
        try:
            assert running.stdout is not None
            line = running.stdout.readline().decode().removesuffix("\n")
            assert line
            assert says in (None, line)
            yield running
        finally:
            running.kill()


def router_process(endpoint: str) -> AbstractContextManager[subprocess.Popen[bytes]]:
    """Start a router in a process of its own."""
    return process("-c", _ROUTER, endpoint)
