"""Two executors of one name, of which the second one started while a link to the first was broken."""

from __future__ import annotations

import sqlite3
from contextlib import ExitStack
from pathlib import Path

import anyio
import anyio.to_thread
import pytest

import seoro
from tests.executors import HELLO, LONG, NAME, executor
from tests.faults.checks import DEADLINE
from tests.faults.conftest import linking
from tests.routers import free_endpoint, router_process


@pytest.mark.more
async def test_the_second_executor_releases_the_name_once_both_are_connected(tmp_path: Path) -> None:
    near, far = free_endpoint(), free_endpoint()
    hello, long = tmp_path / "hello.osc", tmp_path / "long.osc"
    hello.write_text(HELLO)
    long.write_text(LONG)
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
    with ExitStack() as stack:
        stack.enter_context(router_process(far))
        link = ExitStack()
        link.enter_context(linking("connection", port(near), port(far)))
        first = stack.enter_context(executor(tmp_path / "first", connect=near))
        link.close()
        stack.callback(link.close)
        second = stack.enter_context(executor(tmp_path / "second", connect=far))
        async with seoro.Client(far) as client:
            run = await client.submit(NAME, long)
            async for record in run.records():
                if record.get("message") == "begun":
                    break
            link.enter_context(linking("connection", port(near), port(far)))
            with anyio.fail_after(DEADLINE):
                assert await anyio.to_thread.run_sync(second.process.wait, abandon_on_cancel=True) == 2
                assert (await (await client.submit(NAME, hello)).result()).passed
                assert [each.info.file for each in await client.runs(NAME)] == [str(hello)]
        assert first.process.poll() is None
    with sqlite3.connect(tmp_path / "second" / "state" / "runs.sqlite") as database:
        [[state, reason]] = database.execute("SELECT state, reason FROM runs").fetchall()
    assert state == "cancelled"
    assert "an older executor 'lab-a' is reachable again" in reason


def port(endpoint: str) -> str:
    return endpoint.rpartition(":")[2]
