"""Channels of runs on executors: `RemoteRun.subscribe` and `RemoteRun.emit`."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import anyio
import pytest

import seoro
from seoro.bridges.executor import messages as wire
from seoro.embed import accept
from seoro.errors import BackendRefused
from tests.executors import NAME, RunningExecutor, executor

DEADLINE = 30.0  # [s]
HANDOVER = """import osc.types
import osc.helpers

actor porter:
    var trips: int = 0
    event arrived is (trips >= 1)

scenario main:
    robot: porter
    event operator_ready(name: string, distance: length = 2m)
    event ask(n: int)
    do serial:
        increment(robot.trips)
        wait @robot.arrived
        emit ask(1)
        emit ask(2)
        wait @operator_ready
        wait @operator_ready
        log("handed over")
"""


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningExecutor]:
    with executor(tmp_path_factory.mktemp("x"), "--jobs", "2") as running:
        yield running


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "handover.osc"
    path.write_text(HANDOVER)
    return path


@pytest.mark.parametrize("clock", ["virtual", "real"])
async def test_an_application_exchanges_events_with_a_run_over_the_network(
    lab: RunningExecutor, file: Path, clock: Any
) -> None:
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit(NAME, file, clock=clock, seed=1, external=["operator_ready"])
        with anyio.fail_after(DEADLINE):
            async with run.subscribe("robot.arrived") as arrivals, run.subscribe("ask") as asks:
                assert (await anext(arrivals)).name == "robot.arrived"
                assert [(await anext(asks)).arguments for _ in range(2)] == [{"n": 1}, {"n": 2}]
                first = await run.emit("operator_ready", name="Ada", distance=3)
                second = await run.emit("main.operator_ready", name="Bob")
                assert [each async for each in asks] == []
            verdict = await run.result()
        records = [record async for record in run.records()]
    assert verdict.passed
    assert first.arguments == {"name": "Ada", "distance": 3.0}
    assert (second.name, second.arguments["distance"]) == ("main.operator_ready", 2.0)
    outside = [record for record in records if record.get("origin") == "application"]
    assert [(record["t"], record["name"], record["arguments"]) for record in outside] == [first, second]
    assert accept(seoro.load(file), records).accepted


async def test_invalid_emissions_are_refused_as_in_a_local_run(lab: RunningExecutor, file: Path) -> None:
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit(NAME, file, clock="virtual", external=["operator_ready"])
        with anyio.fail_after(DEADLINE):
            async with run.subscribe("ask") as asks:
                await anext(asks)
            for event, fields, message in (
                ("operator_reddy", {}, "unknown event `operator_reddy`"),
                ("ask", {"n": 1}, "is not external"),
                ("operator_ready", {}, "missing field `name`"),
                ("operator_ready", {"name": 1}, "expected a string, found 1"),
                ("operator_ready", {"name": object()}, "invalid fields"),
                ("operator_ready", {"name": "x" * wire.MAX_FIELDS}, "bytes; expected at most"),
            ):
                with pytest.raises(seoro.UsageError, match=message):
                    await run.emit(event, **fields)
            await run.stop()
            await run.result()
            with pytest.raises(seoro.UsageError, match="the run is over"):
                await run.emit("operator_ready", name="Ada")


async def test_emissions_to_a_queued_or_unknown_run_are_refused(tmp_path: Path, file: Path) -> None:
    with executor(tmp_path, "--jobs", "1") as lab:
        async with seoro.Client(lab.endpoint) as client:
            before = await client.submit(NAME, file, clock="virtual", external=["operator_ready"])
            run = await client.submit(NAME, file, clock="virtual", external=["operator_ready"])
            with pytest.raises(seoro.UsageError, match="the run has not started"):
                await run.emit("operator_ready", name="Ada")
            await run.stop()
            await before.stop()
            await before.result()
            await before.remove()
            with pytest.raises(BackendRefused, match="unknown run"):
                await before.emit("operator_ready", name="Ada")


async def test_a_repeated_emission_takes_effect_once(lab: RunningExecutor, file: Path) -> None:
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit(NAME, file, clock="virtual", external=["operator_ready"])
        request = wire.EmitEvent(
            run=run.id, emission="0" * 32, event="operator_ready", fields=b'{"name": "Ada"}', wait=5.0
        )
        with anyio.fail_after(DEADLINE):
            async with run.subscribe("ask") as asks:
                await anext(asks)
            answers = [await run.executor.ask(wire.EMIT_EVENT, request, 5.0) for _ in range(3)]
            assert answers[0] == answers[1] == answers[2]
            await run.emit("operator_ready", name="Bob")
            await run.result()
        records = [record async for record in run.records()]
    assert [each["arguments"]["name"] for each in records if each.get("origin")] == ["Ada", "Bob"]


async def test_subscriptions_of_remote_runs_overflow_without_waiting(lab: RunningExecutor, file: Path) -> None:
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit(NAME, file, clock="virtual", external=["operator_ready"])
        with pytest.raises(seoro.UsageError, match="does not wait for its clients"):
            run.subscribe("ask", on_full="wait")
        with anyio.fail_after(DEADLINE):
            async with (
                run.subscribe("ask", capacity=1) as asks,
                run.subscribe("end") as ends,
                run.subscribe("ask") as others,
            ):
                assert [(await anext(others)).arguments["n"] for _ in range(2)] == [1, 2]
                await run.stop()
                assert [each async for each in ends] == []
                assert (await anext(asks)).arguments == {"n": 1}
                with pytest.raises(seoro.SubscriptionOverflow, match="1 occurrence was lost"):
                    await anext(asks)


async def test_unknown_external_events_are_refused(lab: RunningExecutor, file: Path) -> None:
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit(NAME, file, clock="virtual", external=["go"])
        with anyio.fail_after(DEADLINE), pytest.raises(seoro.UsageError, match="unknown event `go`"):
            await run.result()
        with pytest.raises(seoro.UsageError, match="executors do not replay"):
            await client.submit(NAME, file, replay=[])


@pytest.mark.more
async def test_emissions_to_older_executors_are_refused(tmp_path: Path, file: Path) -> None:
    with executor(tmp_path, before="import seoro.bridges.executor.messages as m; m.MINOR = 3") as lab:
        async with seoro.Client(lab.endpoint) as client:
            with pytest.raises(seoro.UsageError, match="does not support events from applications"):
                await client.submit(NAME, file, external=["operator_ready"])
            run = await client.submit(NAME, file)
            with pytest.raises(seoro.UsageError, match="does not support events from applications"):
                await run.emit("operator_ready", name="Ada")
            await run.stop()


@pytest.mark.more
async def test_the_death_of_an_executor_ends_subscriptions(tmp_path: Path, file: Path) -> None:
    with executor(tmp_path) as lab:
        async with seoro.Client(lab.endpoint, patience=0.5) as client:
            run = await client.submit(NAME, file, clock="virtual", external=["operator_ready"])
            with anyio.fail_after(DEADLINE):
                async with run.subscribe("ask") as asks:
                    assert [(await anext(asks)).arguments["n"] for _ in range(2)] == [1, 2]
                    waiting = asyncio.ensure_future(anext(asks))
                    lab.kill()
                    with pytest.raises(seoro.BackendError):
                        await waiting
