"""Executors at the far end of a link with faults."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.executors import RunningExecutor, executor
from tests.faults.link import FAR

LINK = Path(__file__).with_name("link.py")
ROUTER = """
import sys, time
from seoro.bridges.session import Session
session = Session(listen=sys.argv[1])
print("ready", flush=True)
time.sleep(3600)
"""
PORT = 7447  # in a network of its own


@dataclass(frozen=True)
class Link:
    """A link.

    Args:
        process: Process that carries the traffic.
        prefix: Prefix of commands that run at its far end.
        far: Endpoint of the router for clients at the far end.
        near: Endpoint of the router for clients at the near end.
    """

    process: subprocess.Popen[str]
    prefix: tuple[str, ...]
    far: str
    near: str

    def have(self, **faults: float) -> None:
        """Have faults, and no others than these; see `Faults`."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(json.dumps(faults) + "\n")
        self.process.stdin.flush()
        assert self.process.stdout.readline() == "done\n"


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


@contextmanager
def linking(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, str(LINK), *arguments]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        try:
            yield process
        finally:
            process.kill()


@contextmanager
def network() -> Iterator[str]:
    """A network namespace; the test is skipped where none can be had."""
    name = f"seoro-{os.getpid()}"
    made = subprocess.run(["ip", "netns", "add", name], check=False, capture_output=True, text=True)
    if made.returncode != 0 or not os.access("/dev/net/tun", os.R_OK | os.W_OK):
        pytest.skip(f"no network namespaces here: {made.stderr.strip() or 'no /dev/net/tun'}")
    try:
        yield name
    finally:
        subprocess.run(["ip", "netns", "delete", name], check=True)


@contextmanager
def packet_link() -> Iterator[Link]:
    with network() as name, linking("packets", name) as process:
        prefix = ("ip", "netns", "exec", name)
        yield Link(process, prefix, f"tcp/127.0.0.1:{PORT}", f"tcp/{FAR}:{PORT}")


@contextmanager
def connection_link() -> Iterator[Link]:
    listen, target = free_port(), free_port()
    with linking("connection", str(listen), str(target)) as process:
        yield Link(process, (), f"tcp/127.0.0.1:{target}", f"tcp/127.0.0.1:{listen}")


@contextmanager
def far_router(link: Link) -> Iterator[subprocess.Popen[bytes]]:
    """A router at the far end of a link, in a process of its own."""
    endpoint = link.far.replace("127.0.0.1", "0.0.0.0") if link.prefix else link.far
    command = [*link.prefix, sys.executable, "-c", ROUTER, endpoint]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as router:
        assert router.stdout is not None
        assert router.stdout.readline() == b"ready\n"
        try:
            yield router
        finally:
            router.kill()


@pytest.fixture(params=[pytest.param("packets", marks=pytest.mark.more), "connection"])
def link(request: pytest.FixtureRequest) -> Iterator[Link]:
    """A link that carries packets between networks, and one that carries connections."""
    with packet_link() if request.param == "packets" else connection_link() as made:
        yield made


@pytest.fixture
def far(link: Link, tmp_path: Path) -> Iterator[RunningExecutor]:
    """An executor behind a router at the far end of the link."""
    folder = tmp_path / "far"
    folder.mkdir()
    with far_router(link), executor(folder, connect=link.far, prefix=link.prefix) as running:
        yield running


@pytest.fixture(autouse=True)
def _closed_in(monkeypatch: pytest.MonkeyPatch) -> None:
    """The far network leads nowhere else, so that no keys are needed there."""
    monkeypatch.setattr("seoro.security.network.endpoint_keys.is_local", lambda endpoint: True)
