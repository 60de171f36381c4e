"""Zenoh sessions: real ones, between processes, over socket files."""

import asyncio
import queue
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import AsyncIterator, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import anyio
import pytest

from seoro.bridges.session import (
    AsyncSession,
    InvalidEndpoint,
    NoAnswer,
    NoServer,
    Refused,
    Request,
    Session,
    SessionError,
    asynchronous,
    open_session,
    open_session_at_once,
)
from seoro.bridges.session.endpoints import is_endpoint
from seoro.bridges.session.errors import Unanswered
from seoro.bridges.session.reaching import may_be_late
from seoro.bridges.session.settings import session_settings
from tests.routers import free_endpoint, router_process, routing

SERVER = Path(__file__).with_name("echo_server.py")
KEY = "seoro/1/default/node/echo/cmd/echo"
TOKENS = "seoro/1/default/alive/node/*/*"
TOKEN = "seoro/1/default/alive/node/echo/b1"


@contextmanager
def server(endpoint: str) -> Iterator[subprocess.Popen[bytes]]:
    process = subprocess.Popen([sys.executable, str(SERVER), endpoint])
    try:
        yield process
    finally:
        process.kill()
        process.wait()


@pytest.fixture
async def served(tmp_path: Path) -> AsyncIterator[AsyncSession]:
    """Yield a session that is connected to a server."""
    endpoint = f"unixsock-stream/{tmp_path}/hub.sock"
    async with open_session(listen=endpoint) as session:
        with server(endpoint):
            with anyio.fail_after(30.0):
                async with session.tokens(TOKENS) as tokens:
                    assert await anext(tokens) == (TOKEN, True)
            yield session


async def test_requests_have_replies(served: AsyncSession) -> None:
    assert await served.query(KEY, b"hello", 30) == b"hello"
    assert await served.query(KEY, b"", 30) == b""


CLIENT = """
import asyncio, sys
from seoro.bridges.session import open_session

async def ask():
    async with open_session(connect=sys.argv[1]) as session:
        return await session.query("a/key", b"", 30.0)

print(len(asyncio.run(ask())))
"""


def test_a_large_reply_reaches_a_slow_reader(tmp_path: Path) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/hub.sock"
    session, inbox = Session(listen=endpoint), queue.SimpleQueue[Request]()
    client = subprocess.Popen([sys.executable, "-c", CLIENT, endpoint], stdout=subprocess.PIPE)
    try:
        session.serve("a/key", b"busy", inbox)
        request = inbox.get(timeout=30)
        client.send_signal(signal.SIGSTOP)
        going_on = threading.Timer(0.3, client.send_signal, [signal.SIGCONT])
        going_on.start()
        request.reply(bytes(8_000_000))
        out, _ = client.communicate(timeout=30)
        assert out == b"8000000\n"
        going_on.join()
    finally:
        client.kill()
        session.close()


async def test_a_large_payload_arrives_whole(served: AsyncSession) -> None:
    payload = bytes(range(256)) * 8192
    assert await served.query(KEY, payload, 30) == payload


async def test_a_refusal_carries_its_payload(served: AsyncSession) -> None:
    with pytest.raises(Refused) as caught:
        await served.query(KEY, b"refuse", 30)
    assert caught.value.payload == b"no"


async def test_a_request_without_a_server_fails_at_once(served: AsyncSession) -> None:
    with anyio.fail_after(20.0), pytest.raises(NoServer):
        await served.query("seoro/1/default/node/other/cmd/echo", b"", 30)


async def test_a_request_without_a_reply_times_out(served: AsyncSession) -> None:
    with pytest.raises(NoAnswer):
        await served.query(KEY, b"hold", 0.05)


async def test_a_request_can_be_cancelled(served: AsyncSession) -> None:
    with anyio.move_on_after(0.02) as scope:
        await served.query(KEY, b"hold", 30)
    assert scope.cancelled_caught
    assert await served.query(KEY, b"still there", 30) == b"still there"


async def test_the_death_of_a_server_removes_its_token(served: AsyncSession) -> None:
    with anyio.fail_after(8.0):  # silence takes 15 s
        async with served.tokens(TOKENS) as tokens:
            assert await anext(tokens) == (TOKEN, True)
            with pytest.raises((NoServer, NoAnswer)):
                await served.query(KEY, b"die", 1)
            assert await anext(tokens) == (TOKEN, False)


async def test_connecting_to_an_unused_endpoint_fails_at_once(tmp_path: Path) -> None:
    with anyio.fail_after(20.0), pytest.raises(SessionError, match="cannot connect to unixsock-stream"):
        async with open_session(connect=f"unixsock-stream/{tmp_path}/nobody.sock"):
            pass


@pytest.mark.parametrize(
    "endpoint",
    ["", "127.0.0.1:7447", "tcp/127.0.0.1", "tcq/127.0.0.1:7447", "tcp/::1:7447", "unixpipe/a"],
)
def test_invalid_endpoints_are_refused(endpoint: str) -> None:
    with pytest.raises(InvalidEndpoint, match=r"is an invalid endpoint; expected one like tcp/127.0.0.1:7447"):
        Session(connect=endpoint)
    with pytest.raises(InvalidEndpoint):
        Session(listen=endpoint)


@pytest.mark.parametrize(
    "endpoint", ["tcp/localhost:0", "tls/[::1]:7447", "tcp/1.2.3.4:7447#iface=lo", "unixsock-stream/tmp/a.sock"]
)
def test_valid_endpoints_are_recognised(endpoint: str) -> None:
    assert is_endpoint(endpoint)


def test_a_session_either_listens_or_connects() -> None:
    with pytest.raises(SessionError, match="either listens or connects"):
        Session()


def test_listing_tokens_of_a_closed_session_is_an_error(tmp_path: Path) -> None:
    session = Session(listen=f"unixsock-stream/{tmp_path}/hub")
    session.close()
    with pytest.raises(SessionError, match="cannot list liveliness tokens"):
        session.list_tokens("seoro/**", 1.0)


@contextmanager
def hub_with(tokens: frozenset[str]) -> Iterator[str]:
    """Yield the endpoint of a router with given tokens, each of a separate client."""
    with ExitStack() as opened, routing() as endpoint:
        for token in tokens:
            client = Session(connect=endpoint)
            opened.callback(client.close)
            client.declare_token(token)
        yield endpoint


@pytest.mark.parametrize("waits_for", [1, 3])
def test_token_lists_are_complete_after_other_subscriptions(waits_for: int) -> None:
    tokens = frozenset(f"seoro/1/default/alive/node/{name}/b1" for name in "abc")
    with hub_with(tokens) as endpoint:
        for _ in range(60):
            session = Session(connect=endpoint)
            try:
                reported: queue.SimpleQueue[str] = queue.SimpleQueue()
                stop = session.watch_tokens(TOKENS, lambda token, _, reported=reported: reported.put(token))  # type: ignore[misc]
                for _ in range(waits_for):
                    reported.get(timeout=30)
                stop()
                assert session.list_tokens(TOKENS, 10.0) == tokens
            finally:
                session.close()


def test_a_declared_token_is_listed_at_once() -> None:
    with hub_with(frozenset()) as endpoint:
        watcher, session = Session(connect=endpoint), Session(connect=endpoint)
        try:
            for number in range(60):
                session.declare_token(f"seoro/1/default/alive/node/echo/{number}")
                assert len(watcher.list_tokens(TOKENS, 10.0)) == number + 1
        finally:
            watcher.close()
            session.close()


async def test_a_session_whose_opening_is_cancelled_is_closed(tmp_path: Path) -> None:
    async def open_and_wait(endpoint: str) -> None:
        async with open_session(listen=endpoint):
            await asyncio.sleep(3600)

    for number, delay in enumerate((0.0, 0.002, 0.005, 0.01, 0.02)):
        task = asyncio.create_task(open_and_wait(f"unixsock-stream/{tmp_path}/{number}.sock"))
        await asyncio.sleep(delay)
        task.cancel()
        await asyncio.wait([task])
        assert task.cancelled()
        assert [file for file in open_files() if str(tmp_path) in file] == [], f"after {delay} s"


def open_files() -> list[str]:
    """Return the open files of this process."""
    found = []
    for entry in Path("/proc/self/fd").iterdir():
        with suppress(FileNotFoundError):  # that of the listing itself
            found.append(str(entry.readlink()))
    return found


@pytest.mark.parametrize("patient", [True, False])
def test_the_send_queue_holds_a_megabyte(patient: bool) -> None:
    queue = session_settings(None, "tcp/127.0.0.1:7447", patient=patient)["transport"]["link"]["tx"]["queue"]
    assert queue["size"]["data"] * 65_536 == 1_048_576


@pytest.mark.parametrize("kind", ["port", "file"])
async def test_a_late_process_is_reached(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    endpoint = free_endpoint() if kind == "port" else f"unixsock-stream/{tmp_path}/hub.sock"
    with router_process(endpoint) as router:
        late: list[bool] = []

        async def is_late(endpoint: object) -> bool:
            late.append(await may_be_late(endpoint))
            router.send_signal(signal.SIGCONT)
            return late[-1]

        monkeypatch.setattr(asynchronous, "may_be_late", is_late)
        router.send_signal(signal.SIGSTOP)
        async with open_session(connect=endpoint) as session:
            assert late == [True]
            assert not session.is_cut_off


async def test_a_silent_process_is_given_up() -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent, pytest.raises(Unanswered, match="nothing answers"):
        async with open_session_at_once(connect=f"tcp/127.0.0.1:{silent.getsockname()[1]}"):
            pass


async def test_only_listening_processes_may_be_late(tmp_path: Path) -> None:
    file = tmp_path / "hub.sock"
    for endpoint in (free_endpoint(), f"unixsock-stream/{file}", "udp/127.0.0.1:7447", None):
        assert not await may_be_late(endpoint)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        port = silent.getsockname()[1]
        assert await may_be_late(f"tcp/127.0.0.1:{port}")
        assert not await may_be_late(f"tls/127.0.0.1:{port}")
