"""Recorded exchanges of nodes and executors with their clients."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator, Iterator, Sequence
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from seoro.bridges.executor import asking
from seoro.bridges.session import AsyncSession, query_parts


@dataclass(frozen=True)
class Exchange:
    """A request and its answer, as bytes.

    Args:
        verb: Name of the verb.
        request: The request.
        parts: Parts of the answer that came before its end.
        reply: End of the answer.
    """

    verb: str
    request: bytes
    parts: tuple[bytes, ...]
    reply: bytes


def write(path: Path, exchanges: Sequence[Exchange]) -> None:
    """Write exchanges as lines of JSON with bytes in hexadecimal digits."""
    lines = [
        json.dumps(
            {
                "verb": each.verb,
                "request": each.request.hex(),
                "parts": [part.hex() for part in each.parts],
                "reply": each.reply.hex(),
            }
        )
        for each in exchanges
    ]
    path.write_text("".join(f"{line}\n" for line in lines))


def read(path: Path) -> list[Exchange]:
    """Read exchanges."""
    return [
        Exchange(
            each["verb"],
            bytes.fromhex(each["request"]),
            tuple(map(bytes.fromhex, each["parts"])),
            bytes.fromhex(each["reply"]),
        )
        for each in map(json.loads, path.read_text().splitlines())
    ]


@contextmanager
def recording() -> Iterator[list[Exchange]]:
    """Record the exchanges of this process as a client, in the order of their ends."""
    exchanges: list[Exchange] = []
    query = AsyncSession.query

    async def querying(self: AsyncSession, key: str, payload: bytes, *rest: Any, **more: Any) -> bytes:
        reply = await query(self, key, payload, *rest, **more)
        exchanges.append(Exchange(key.rpartition("/")[2], payload, (), reply))
        return reply

    @asynccontextmanager
    async def querying_parts(
        session: AsyncSession, key: str, payload: bytes, *rest: Any
    ) -> AsyncIterator[AsyncIterator[tuple[bool, bytes]]]:
        async with query_parts(session, key, payload, *rest) as answers:
            yield noted(answers, key.rpartition("/")[2], payload)

    async def noted(
        answers: AsyncIterator[tuple[bool, bytes]], verb: str, payload: bytes
    ) -> AsyncIterator[tuple[bool, bytes]]:
        parts: list[bytes] = []
        async for is_part, data in answers:
            if is_part:
                parts.append(data)
            else:
                exchanges.append(Exchange(verb, payload, tuple(parts), data))
            yield is_part, data

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(AsyncSession, "query", querying)
        patch.setattr(asking, "query_parts", querying_parts)
        yield exchanges
