"""Publishing and subscribing over real sessions."""

import asyncio
import os
import signal
import subprocess
import sys
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest

from seoro.bridges.session import (
    AsyncSession,
    Bound,
    Mailbox,
    Sample,
    SessionError,
    open_session,
    publishing,
    subscribing,
)

KEY = "seoro/test/topic"


@asynccontextmanager
async def connected(folder: Path) -> AsyncIterator[tuple[AsyncSession, AsyncSession]]:
    """Yield two sessions at a router."""
    endpoint = f"unixsock-stream/{folder}/hub.sock"
    async with (
        open_session(listen=endpoint),
        open_session(connect=endpoint) as one,
        open_session(connect=endpoint) as other,
    ):
        yield one, other


@asynccontextmanager
async def reading(session: AsyncSession, key: str, history: int = 0) -> AsyncIterator[Mailbox[Sample]]:
    """Yield the publications on a key."""
    samples: Mailbox[Sample] = Mailbox(Bound(10))

    def take(sample: Sample) -> None:
        samples.put(sample, len(sample.payload))

    async with subscribing(session, key, take, history=history, recover=bool(history)):
        yield samples


async def test_samples_arrive_with_their_attachments(tmp_path: Path) -> None:
    async with (
        connected(tmp_path) as (one, other),
        reading(other, "seoro/*/topic") as samples,
        publishing(one, KEY) as publisher,
    ):
        with anyio.fail_after(30.0):
            await publisher.wait_for_subscriber()
            publisher.put(b"hello", b"beside")
            publisher.put(b"")
            first, second = await samples.get(), await samples.get()
    assert (first.key, first.payload, first.attachment) == (KEY, b"hello", b"beside")
    assert (second.payload, second.attachment) == (b"", b"")
    assert first.arrived <= second.arrived


async def test_late_subscribers_receive_cached_samples(tmp_path: Path) -> None:
    async with connected(tmp_path) as (one, other), publishing(one, KEY, keep=2, recover=True) as publisher:
        for number in range(5):
            publisher.put(b"%d" % number)
        got = []
        with anyio.fail_after(30.0):
            async with reading(other, "seoro/test/*", history=2) as samples:
                while b"4" not in got:  # publications in transit arrive first
                    got.append((await samples.get()).payload)
                await publisher.wait_for_subscriber()
                publisher.put(b"live")
                got.append((await samples.get()).payload)
    assert got[-3:] == [b"3", b"4", b"live"]


async def test_subscribers_receive_cached_samples_of_later_publishers(tmp_path: Path) -> None:
    async with (
        connected(tmp_path) as (one, other),
        reading(other, KEY, history=1) as samples,
        publishing(one, KEY, keep=1, reliable=False) as publisher,
    ):
        publisher.put(b"kept")
        with anyio.fail_after(30.0):
            assert (await samples.get()).payload == b"kept"


async def test_closed_subscriptions_receive_and_closed_publishers_send_no_samples(tmp_path: Path) -> None:
    async with connected(tmp_path) as (one, other):
        async with reading(other, KEY) as samples, publishing(one, KEY) as publisher:
            pass
        with pytest.raises(SessionError, match=f"cannot publish on {KEY}"):
            publisher.put(b"")
        assert samples.get_nowait() is None


async def test_invalid_keys_are_refused(tmp_path: Path) -> None:
    async with connected(tmp_path) as (one, _):
        with pytest.raises(SessionError, match="cannot publish on a//b"):
            async with publishing(one, "a//b"):
                pass
        with pytest.raises(SessionError, match="cannot subscribe to a//b"):
            async with reading(one, "a//b"):
                pass


HUB = """
import sys
from seoro.bridges.session import Session
session = Session(listen=sys.argv[1])
print("ready", flush=True)
sys.stdin.read()
"""


async def test_publishing_continues_while_the_router_hangs(tmp_path: Path) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/hub.sock"
    command = [sys.executable, "-c", HUB, endpoint]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as hub:
        try:
            assert hub.stdout is not None and hub.stdout.readline() == b"ready\n"
            async with (
                open_session(connect=endpoint, patient=False) as one,
                open_session(connect=endpoint) as other,
                reading(other, KEY),
                publishing(one, KEY) as publisher,
            ):
                await publisher.wait_for_subscriber()
                os.kill(hub.pid, signal.SIGSTOP)
                taken = []
                for _ in range(30):
                    start = time.monotonic()
                    publisher.put(bytes(100_000))
                    taken.append(time.monotonic() - start)
                os.kill(hub.pid, signal.SIGCONT)
            assert sorted(taken)[-3] < 0.5, "a busy machine may interrupt two"
        finally:
            hub.kill()


async def test_declarations_of_a_cancelled_task_are_undone(tmp_path: Path) -> None:
    """The declaring thread continues after the cancellation."""
    async with connected(tmp_path) as (one, other), other.tokens("@test/**") as changes:
        for number in range(20):
            task = asyncio.create_task(_hold_token(one, f"@test/{number}"))
            for _ in range(number % 5):
                await asyncio.sleep(0)
            task.cancel()
            await asyncio.wait([task])
            assert task.cancelled()
        async with one.token("@test/end"):
            alive: dict[str, bool] = {}
            with anyio.fail_after(30.0):
                while not alive.get("@test/end"):
                    alive.update([await changes.get()])
    assert [key for key, there in alive.items() if there] == ["@test/end"]


async def _hold_token(session: AsyncSession, key: str) -> None:
    async with session.token(key):
        await asyncio.sleep(3600)
