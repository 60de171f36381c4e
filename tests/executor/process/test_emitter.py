"""Requests to emit an event, received by the process of a run."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import cast

import anyio
import pytest

from seoro.bridges.executor import messages as wire
from seoro.bridges.wire import decode, encode
from seoro.embed.runs import Run
from seoro.executor.process.emitter import Emitter

NESTED = b'{"deep": ' + b"[" * 4000 + b"]" * 4000 + b"}"


class NoRun:
    async def emit(self, event: str, **fields: object) -> None:
        raise AssertionError("the fields are invalid")


@pytest.fixture(autouse=True)
def _default_recursion_limit() -> Iterator[None]:
    """Use the limit of a new process, in place of that of other tests."""
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(1000)
    yield
    sys.setrecursionlimit(before)


@pytest.mark.parametrize("fields", [b"{", b"[1]", b'"text"', NESTED], ids=["cut", "list", "text", "nested"])
async def test_invalid_fields_are_refused(fields: bytes) -> None:
    request = wire.EmitEvent(run="a" * 32, emission="b" * 32, event="go", fields=fields, wait=0.0)
    answers = list[bytes]()
    async with anyio.create_task_group() as tasks:
        Emitter(cast("Run", NoRun()), tasks, answers.append).emit(encode(request))
    (answer,) = answers
    assert decode(wire.Emitted, answer).refused.startswith("invalid fields of event `go`")
