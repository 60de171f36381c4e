"""The trace of a run."""

import io
import json
from typing import Any

import pytest

from seoro.embed.options import Options
from tests.runtime.conftest import Prepare, prepare_text

__all__ = ["prepare_text"]

SCENARIO = """
scenario part:
    level: uint = 1
    event near
    cover(level, event: near)
    do serial:
        wait elapsed(1s)
        emit near

scenario main:
    var count: int = 0
    event go
    do parallel:
        serial:
            part()
            increment(count)
            emit go
            wait elapsed(3s)
        serial:
            wait @go
            log("gone")
            part() with:
                repeat(2)
        nap: serial:
            wait elapsed(10s)
    with:
        timeout(5s)
"""


@pytest.fixture
async def trace(prepare_text: Prepare) -> list[dict[str, Any]]:
    """The records of a run that fails after 5 s."""
    options = Options(seed=0, clock="virtual")
    async with prepare_text(SCENARIO, options) as run, run.running():
        return [json.loads(json.dumps(record)) async for record in run.trace()]


def as_file(records: list[dict[str, Any]]) -> io.BytesIO:
    return io.BytesIO("".join(json.dumps(record) + "\n" for record in records).encode())
