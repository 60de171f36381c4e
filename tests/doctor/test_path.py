"""The way to an executor, with what can be wrong on it: each is told by the hop at which it is wrong."""

import os
import signal
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from seoro.doctor.endpoint import look_at_endpoint
from seoro.doctor.findings import Finding, Health
from seoro.doctor.path import look_along
from tests.executors import NAME, RunningExecutor, executor


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningExecutor]:
    with executor(tmp_path_factory.mktemp("x")) as running:
        yield running


async def look(endpoint: str, name: str | None = None) -> list[Finding]:
    return [finding async for finding in look_along(endpoint, name)]


@contextmanager
def listening() -> Iterator[int]:
    """A port at which somebody listens who speaks something else."""
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


async def test_all_is_well(lab: RunningExecutor) -> None:
    found = await look(lab.endpoint, NAME)
    assert {finding.health for finding in found} == {Health.OK}
    text = "\n".join(f"{finding.what}: {finding.text}" for finding in found)
    for part in (
        "Zenoh answers",
        "is of seoro",
        "its clock is",
        "(p50)",
        "(p99 of 100)",
        "of disk left",
        "simulators",
    ):
        assert part in text


async def test_all_executors_are_looked_at_if_none_is_named(lab: RunningExecutor) -> None:
    assert NAME in {finding.what for finding in await look(lab.endpoint)}


async def test_an_executor_that_is_not_there_is_told_with_those_that_are(lab: RunningExecutor) -> None:
    *_, last = await look(lab.endpoint, "nobody")
    assert (last.what, last.health) == ("executor", Health.FAILED)
    assert NAME in last.help


@pytest.mark.parametrize(
    ("endpoint", "text"),
    [
        ("nonsense", "is none"),
        ("tcp/127.0.0.1:99999", "there is no port 99999"),
        ("unixsock-stream//nowhere/hub", "there is no socket"),
        ("tcp/name.invalid:7470", "belongs to no machine"),
    ],
)
async def test_an_endpoint_that_cannot_be_is_told(endpoint: str, text: str) -> None:
    [finding] = await look(endpoint)
    assert finding.health is Health.FAILED
    assert text in finding.text
    assert finding.help


async def test_a_closed_port_is_told() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    finding = await look_at_endpoint(f"tcp/127.0.0.1:{port}")
    assert finding.health is Health.FAILED
    assert "nothing listens" in finding.text


async def test_somebody_else_at_the_port_is_told() -> None:
    with listening() as port:
        first, *_, last = await look(f"tcp/127.0.0.1:{port}")
    assert first.health is Health.OK
    assert (last.what, last.health) == ("session", Health.FAILED)
    assert "speaks Zenoh with us" in last.text


async def test_an_endpoint_outside_this_machine_without_keys_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    async def is_there(endpoint: str) -> Finding:
        return Finding("endpoint", Health.OK, endpoint)

    monkeypatch.setattr("seoro.doctor.path.look_at_endpoint", is_there)
    *_, last = await look("tcp/192.0.2.1:7470")
    assert (last.what, last.health) == ("keys", Health.FAILED)
    assert "tls/192.0.2.1:7470" in last.help


@pytest.mark.slow
async def test_an_executor_that_stands_still_is_told(tmp_path: Path) -> None:
    with executor(tmp_path) as running:
        os.kill(running.process.pid, signal.SIGSTOP)
        try:
            *_, last = await look(running.endpoint, NAME)
        finally:
            os.kill(running.process.pid, signal.SIGCONT)
    assert last.health is Health.FAILED
    assert "stands still" in last.help
