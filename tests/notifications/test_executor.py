"""Notifications of an executor."""

from __future__ import annotations

from pathlib import Path

import anyio.to_thread
import pytest

import seoro
from seoro.cli.main import main
from tests.executors import HELLO, LONG, NAME, executor
from tests.notifications.hooks import Hook, hooked


async def test_an_executor_notifies_of_each_run_also_of_those_that_it_stops(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SEORO_NOTIFY_SECRET", "s3cret")
    for name, text in (("hello", HELLO), ("long", LONG)):
        (tmp_path / f"{name}.osc").write_text(text)
    with (
        hooked(Hook()) as hook,
        hooked(Hook(statuses=(403,))) as other,
        executor(tmp_path, "--notify", hook.url, "--notify", other.url) as running,
    ):
        async with seoro.Client(running.endpoint) as client:
            passed = await client.submit(NAME, tmp_path / "hello.osc")
            await passed.result()
            stopped = await client.submit(NAME, tmp_path / "long.osc")
            async for record in stopped.records():
                if record["kind"] == "log":
                    break
        assert await anyio.to_thread.run_sync(running.end) == 0
    found = [message["run"] for message in hook.messages]
    assert [(run["run"], run["status"], run["executor"]) for run in found] == [
        (passed.id, "passed", NAME),
        (stopped.id, "cancelled", NAME),
    ]
    assert all(headers["Seoro-Signature"].startswith("sha256=") for headers in hook.headers)
    assert len(other.bodies) == 2
    assert "notification not delivered: http://127.0.0.1" in capfd.readouterr().err


def test_an_executor_refuses_invalid_urls(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["serve", "--folder", str(tmp_path), "--notify", "http://example.org/secret"]) == 2
    assert "secret" not in capsys.readouterr().err
