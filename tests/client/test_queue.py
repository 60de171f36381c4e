"""Waiting runs of an executor, versions and clocks."""

import json
import math
from pathlib import Path
from typing import Any

import anyio
import pytest

import seoro
from seoro.bridges.executor.messages import State
from seoro.cli.main import main
from tests.executors import HELLO, LONG, NAME, executor

DEADLINE = 30.0  # [s]


@pytest.fixture
def hello(tmp_path: Path) -> Path:
    file = tmp_path / "hello.osc"
    file.write_text(HELLO)
    return file


async def test_users_take_turns_and_higher_priorities_run_first(
    tmp_path: Path, hello: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def submitting(name: str) -> None:
        monkeypatch.setattr("seoro.client.whoami", lambda: name)

    long = tmp_path / "long.osc"
    long.write_text(LONG)
    with executor(tmp_path) as lab:
        async with seoro.Client(lab.endpoint) as client:
            first = await client.submit(NAME, long)
            submitting("many@ci")
            many = [await client.submit(NAME, hello) for _ in range(3)]
            submitting("one@desk")
            one = await client.submit(NAME, hello)
            urgent = await client.submit(NAME, hello, priority=5)
            assert urgent.info.place == 1
            places = {run.id: run.info.place for run in await client.runs()}
            [status] = await client.describe()
            await first.stop()
            with anyio.fail_after(DEADLINE):
                for run in (*many, one, urgent):
                    await run.result()
            found = {run.id: run for run in await client.runs()}
    order = [urgent.id, many[0].id, one.id, many[1].id, many[2].id]
    assert [places[run] for run in order] == [1, 2, 3, 4, 5]
    assert places[first.id] is None
    assert (status.info.running, status.info.waiting) == (1, 5)
    assert sorted(order, key=lambda run: found[run].info.started or 0.0) == order


@pytest.mark.more
async def test_the_queue_survives_a_restart(tmp_path: Path, hello: Path) -> None:
    long = tmp_path / "long.osc"
    long.write_text(LONG)
    with executor(tmp_path) as lab:
        async with seoro.Client(lab.endpoint) as client:
            await client.submit(NAME, long)
            late = await client.submit(NAME, hello, priority=-3)
            next_one = await client.submit(NAME, hello)
            lab.kill()
    with executor(tmp_path) as lab:
        async with seoro.Client(lab.endpoint) as client:
            with anyio.fail_after(DEADLINE):
                found = [await client.run(run.id) for run in (next_one, late)]
                for run in found:
                    assert (await run.result()).passed
            assert found[1].info.priority == -3
            started = [run.info.started for run in found]
    assert started == sorted(started, key=lambda time: time or 0.0)


@pytest.mark.more
def test_queue_places_and_executors_are_listed(
    tmp_path: Path, hello: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    async def submit() -> None:
        async with seoro.Client() as client:
            long = tmp_path / "long.osc"
            long.write_text(LONG)
            await client.submit(NAME, long)
            await client.submit(NAME, hello, priority=2)

    with executor(tmp_path) as lab:
        monkeypatch.setenv("SEORO_EXECUTOR", lab.endpoint)
        anyio.run(submit)
        assert main(["ps", "--verbose"]) == 0
        out = capsys.readouterr().out
        assert main(["ps", "--json"]) == 0
        youngest: dict[str, Any] = json.loads(capsys.readouterr().out)[0]
    assert " queued #1, priority 2 " in out
    assert f"{NAME}     {seoro.__version__}    1     1        1" in out
    assert (youngest["place"], youngest["priority"]) == (1, 2)


async def test_an_invalid_priority_is_refused(hello: Path) -> None:
    with pytest.raises(seoro.UsageError, match="invalid priority 101"):
        await seoro.Client().submit(NAME, hello, priority=101)


@pytest.mark.parametrize("seconds", [math.nan, math.inf, 0.0, -1.0])
async def test_invalid_times_are_refused_before_the_upload(hello: Path, seconds: float) -> None:
    with pytest.raises(seoro.UsageError, match=r"invalid `stop_if_lost` .*; expected a number of seconds above 0"):
        await seoro.Client().submit(NAME, hello, stop_if_lost=seconds)
    with pytest.raises(seoro.UsageError, match=r"(invalid )?`timeout`.* seconds above 0"):
        await seoro.Client().submit(NAME, hello, timeout=seconds)


async def test_invalid_times_of_options_are_refused_before_the_upload(hello: Path) -> None:
    with pytest.raises(seoro.UsageError, match="expected seconds from 0"):
        await seoro.Client().submit(NAME, hello, grace=math.inf)


# ---------------------------------------------------------------- versions


async def test_an_executor_of_another_version_is_reported(
    tmp_path: Path, hello: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.bridges.executor.finding.TIMEOUT", 0.5)
    with executor(tmp_path, before="import seoro.bridges.wire.keys as keys; keys.MAJOR = 2") as lab:
        async with seoro.Client(lab.endpoint) as client:
            for asked in (client.submit(NAME, hello), client.runs(), client.run("0" * 32, NAME)):
                with pytest.raises(
                    seoro.UsageError, match=r"speaks version 2 of the protocol; expected version 1"
                ):
                    await asked
            with pytest.raises(seoro.UsageError, match="unknown executor 'lab-z'"):
                await client.submit("lab-z", hello)


@pytest.mark.more
async def test_fields_unknown_to_an_older_executor_are_omitted(tmp_path: Path, hello: Path) -> None:
    with executor(tmp_path, before="import seoro.bridges.executor.messages as m; m.MINOR = 0") as lab:
        async with seoro.Client(lab.endpoint) as client:
            with pytest.raises(seoro.UsageError, match="priorities"):
                await client.submit(NAME, hello, priority=1)
            assert await client.runs() == []
            run = await client.submit(NAME, hello)
            with anyio.fail_after(DEADLINE):
                assert (await run.result()).passed
            assert run.state is State.PASSED
