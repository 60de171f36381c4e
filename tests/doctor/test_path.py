"""Findings about the path to an executor: each problem is found at its hop."""

import math
import os
import signal
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from seoro.doctor import peers
from seoro.doctor.endpoint import check_endpoint
from seoro.doctor.findings import Finding, Health
from seoro.doctor.path import check_path_to_executors
from seoro.executor.sandbox import bubblewrap
from tests.executors import NAME, RunningExecutor, executor


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningExecutor]:
    with executor(tmp_path_factory.mktemp("x")) as running:
        yield running


async def look(endpoint: str, name: str | None = None) -> list[Finding]:
    return [finding async for finding in check_path_to_executors(endpoint, name)]


@contextmanager
def listening() -> Iterator[int]:
    """Listen at a port with another protocol."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            try:
                while True:
                    connection, _ = server.accept()
                    with connection:
                        connection.sendall(b"SSH-2.0-OpenSSH_9.2\r\n")
            except OSError:  # closed
                return

        thread = threading.Thread(target=serve)
        thread.start()
        yield server.getsockname()[1]
        server.shutdown(socket.SHUT_RDWR)
    thread.join()


async def test_a_healthy_executor_has_no_problems(lab: RunningExecutor, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peers, "SLOW", math.inf)  # a busy machine answers late
    found = await look(lab.endpoint, NAME)
    unsandboxed = [finding for finding in found if finding.text.startswith("does not sandbox runs: ")]
    assert len(unsandboxed) == bool(bubblewrap.trouble())
    assert {finding.health for finding in found if finding not in unsandboxed} == {Health.OK}
    text = "\n".join(f"{finding.what}: {finding.text}" for finding in found)
    for part in (
        "Zenoh answers",
        "same as here",
        "its clock is",
        "(p50)",
        "(p99 of 100)",
        "of disk left",
        "simulators",
    ):
        assert part in text


async def test_all_executors_are_checked_without_a_name(lab: RunningExecutor) -> None:
    assert NAME in {finding.what for finding in await look(lab.endpoint)}


async def test_an_unknown_executor_is_reported_with_the_known_ones(lab: RunningExecutor) -> None:
    *_, last = await look(lab.endpoint, "nobody")
    assert (last.what, last.health) == ("executor", Health.FAILED)
    assert NAME in last.help


@pytest.mark.parametrize(
    ("endpoint", "text"),
    [
        ("nonsense", "invalid endpoint"),
        ("tcp/127.0.0.1:99999", "invalid port 99999"),
        ("unixsock-stream//nowhere/hub", "socket not found"),
        ("tcp/name.invalid:7470", "unknown host"),
    ],
)
async def test_an_invalid_endpoint_is_reported(endpoint: str, text: str) -> None:
    [finding] = await look(endpoint)
    assert finding.health is Health.FAILED
    assert text in finding.text
    assert finding.help


async def test_a_closed_port_is_reported() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    finding = await check_endpoint(f"tcp/127.0.0.1:{port}")
    assert finding.health is Health.FAILED
    assert "nothing listens" in finding.text


async def test_another_server_at_the_port_is_reported() -> None:
    with listening() as port:
        first, *_, last = await look(f"tcp/127.0.0.1:{port}")
    assert first.health is Health.OK
    assert (last.what, last.health) == ("session", Health.FAILED)
    assert "no Zenoh session with" in last.text


async def test_a_remote_endpoint_without_keys_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    async def is_there(endpoint: str) -> Finding:
        return Finding("endpoint", Health.OK, endpoint)

    monkeypatch.setattr("seoro.doctor.path.check_endpoint", is_there)
    *_, last = await look("tcp/192.0.2.1:7470")
    assert (last.what, last.health) == ("keys", Health.FAILED)
    assert "tls/192.0.2.1:7470" in last.help


@pytest.mark.more
async def test_a_suspended_executor_is_reported(tmp_path: Path) -> None:
    with executor(tmp_path) as running:
        os.kill(running.process.pid, signal.SIGSTOP)
        try:
            *_, last = await look(running.endpoint, NAME)
        finally:
            os.kill(running.process.pid, signal.SIGCONT)
    assert last.health is Health.FAILED
    assert "suspended (`kill -STOP`" in last.help


@pytest.mark.parametrize(("most", "health"), [(0.02, Health.OK), (peers.SLOW, Health.WARNING)])
def test_slow_answers_are_a_warning(most: float, health: Health) -> None:
    finding = peers.latency_finding("lab-a", 0.01, most, 100)
    text = f"latency 10.0 ms (p50), {1000.0 * most:.1f} ms (p99 of 100)"
    assert (finding.health, finding.text) == (health, text)
