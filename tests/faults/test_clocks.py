"""An executor whose clock is an hour off: by libfaketime, where it is installed, and by a clock of Python's."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import anyio
import pytest

import seoro
from seoro.bridges.executor.messages import State
from seoro.cli.main import main
from tests.executors import HELLO, LONG, NAME, RunningExecutor, executor
from tests.faults.checks import DEADLINE, follow

HOUR = 3600.0  # [s]
INJECTED = f"""
import time
real = time.time
time.time = lambda: real() + {HOUR}
"""
LIBRARIES = ("/usr/lib/*/faketime/libfaketimeMT.so.1", "/usr/lib*/faketime/libfaketimeMT.so.1")


@pytest.fixture(params=["libfaketime", "injected"])
def ahead(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[RunningExecutor]:
    """An executor whose clock is an hour ahead of this machine."""
    if request.param == "injected":
        with executor(tmp_path, before=INJECTED) as running:
            yield running
        return
    library = next((str(path) for each in LIBRARIES for path in Path("/").glob(each[1:])), None)
    if library is None:
        pytest.skip("libfaketime is not installed")
    settings = (f"LD_PRELOAD={library}", f"FAKETIME=+{HOUR:.0f}s", "FAKETIME_DONT_FAKE_MONOTONIC=1")
    with executor(tmp_path, prefix=("env", *settings)) as running:
        yield running


async def test_a_wrong_clock_of_an_executor_is_reported_and_has_no_other_effect(
    ahead: RunningExecutor, tmp_path: Path
) -> None:
    file = tmp_path / "hello.osc"
    file.write_text(HELLO)
    async with seoro.Client(ahead.endpoint) as client:
        [status] = await client.describe()
        assert status.clock is not None
        assert abs(status.clock.offset - HOUR) < 0.5
        run = await client.submit(NAME, file)
        await follow(run)
        assert run.info.ended is not None
        assert abs(run.info.ended - time.time() - HOUR) < DEADLINE


@pytest.mark.more
async def test_runs_are_stopped_only_after_their_client_disappears(ahead: RunningExecutor, tmp_path: Path) -> None:
    file = tmp_path / "long.osc"
    file.write_text(LONG)
    async with seoro.Client(ahead.endpoint) as client:
        run = await client.submit(NAME, file, stop_if_lost=1.5)
        with anyio.move_on_after(2.5):
            async for _ in run.parts():
                pass
        assert run.state is State.RUNNING
        with anyio.fail_after(DEADLINE):
            found = await client.run(run.id)
            assert "lost its client" in (await found.result()).reason


@pytest.mark.more
def test_times_are_shown_by_the_clock_of_the_client(
    ahead: RunningExecutor, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("SEORO_EXECUTOR", ahead.endpoint)
    file = tmp_path / "hello.osc"
    file.write_text(HELLO)
    assert main(["exec", str(file), "--on", NAME]) == 0
    assert main(["ps", "--verbose"]) == 0
    out = capsys.readouterr().out
    run, _, state, since, unit = out.splitlines()[-1].split()[:5]
    assert (state, unit) == ("passed", "s")
    assert float(since) < DEADLINE
    assert "3600.0 s ahead" in out or "3599.9 s ahead" in out
    assert main(["attach", run]) == 0
    assert "3600.0 s ahead of this machine" in capsys.readouterr().err.replace("3599.9", "3600.0")
