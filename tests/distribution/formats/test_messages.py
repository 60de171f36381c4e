"""Messages of each released version: nodes, executors and clients of neighbouring versions work together.

The code here is one side, of today; recorded bytes are the other side, of that version.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgpack
import pytest

from seoro.bridges import wire
from seoro.bridges.executor import messages
from seoro.bridges.executor.verbs import EXECUTOR_VERBS
from seoro.bridges.session import open_session
from seoro.bridges.wire import NAMESPACE
from seoro.bridges.wire.keys import executor_command
from tests.distribution.formats.exchanges import Exchange, read
from tests.distribution.formats.make import FORMATS
from tests.executors import NAME, executor

VERSIONS = sorted(path.name for path in FORMATS.iterdir())
SERVERS = {"node": wire.NODE_VERBS, "executor": EXECUTOR_VERBS}
RECORDED = [
    pytest.param(server, each, id=f"{version}-{server}-{each.verb}-{number}")
    for version in VERSIONS
    for server in SERVERS
    for number, each in enumerate(read(FORMATS / version / f"{server}.jsonl"))
]


def lost(before: Any, after: Any, path: str = "") -> list[str]:
    """Return the paths of what `before` has and `after` has not."""
    match before, after:
        case dict(), dict():
            return [
                each
                for key, value in before.items()
                for each in ([f"{path}.{key}"] if key not in after else lost(value, after[key], f"{path}.{key}"))
            ]
        case list(), list() if len(before) == len(after):
            pairs = enumerate(zip(before, after, strict=True))
            return [each for number, pair in pairs for each in lost(*pair, f"{path}[{number}]")]
    return [] if before == after else [path]


@pytest.mark.parametrize(("server", "exchange"), RECORDED)
def test_a_server_of_today_reads_the_request_without_loss(server: str, exchange: Exchange) -> None:
    message = SERVERS[server][exchange.verb].read(exchange.request)
    assert not lost(msgpack.unpackb(exchange.request), msgpack.unpackb(wire.encode(message)))


@pytest.mark.parametrize(("server", "exchange"), RECORDED)
def test_a_client_of_today_reads_the_reply_without_loss(server: str, exchange: Exchange) -> None:
    message = SERVERS[server][exchange.verb].read_reply(exchange.reply)
    assert not lost(msgpack.unpackb(exchange.reply), msgpack.unpackb(wire.encode(message)))


@pytest.mark.more
@pytest.mark.parametrize("version", VERSIONS)
async def test_an_executor_of_today_serves_a_client_of_that_version(version: str, tmp_path: Path) -> None:
    exchanges = read(FORMATS / version / "executor.jsonl")
    with executor(tmp_path) as running:
        async with open_session(connect=running.endpoint) as session:
            for each in exchanges:
                if each.verb == messages.RECORDS.name:
                    continue  # asks in parts, for a run that has ended
                verb = EXECUTOR_VERBS[each.verb]
                found = await session.query(executor_command(NAMESPACE, NAME, each.verb), each.request, 30.0)
                verb.read_reply(found)
                missing = lost(shape(msgpack.unpackb(each.reply)), shape(msgpack.unpackb(found)))
                assert not missing, (each.verb, missing)


def shape(value: Any) -> Any:
    """Return the fields of a message without its values, which differ from run to run."""
    return {key: shape(each) for key, each in value.items()} if isinstance(value, dict) else None
