"""Channels for applications: `Run.subscribe` and `Run.emit`."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any, Literal

import pytest

import seoro
from seoro.embed import prepare
from seoro.embed.options import Options
from seoro.errors import cause_of

TICKS = """import osc.types
scenario main:
    event tick(n: int)
    var n: int = 0
    do serial:
        wait elapsed(1s)
        emit tick(1)
        emit tick(2)
        wait elapsed(1s)
        emit tick(3)
        wait elapsed(1h)
"""

HANDOVER = """import osc.types
import osc.helpers

enum color: [red, green]

struct place:
    x: length
    label: string

actor porter:
    var trips: int = 0
    event arrived is (trips >= 1)
    event released(by: string)

scenario main:
    robot: porter
    event operator_ready(name: string, distance: length = 2m, light: color = color!green)
    event moved(to: place, sizes: list of length)
    event ask
    do serial:
        wait elapsed(2s)
        increment(robot.trips)
        wait @robot.arrived
        ready: wait @operator_ready
        emit ask
        wait @operator_ready
        log("handed over")
        wait @robot.released
"""

Load = Callable[[str], seoro.Scenario]


def events_of(records: list[dict[str, Any]], name: str) -> list[dict[str, Any]]:
    return [record for record in records if record["kind"] == "event" and record["name"] == name]


# ------------------------------------------------------------ receiving


@pytest.mark.parametrize("name", ["tick", "main.tick"])
async def test_a_subscription_receives_every_occurrence_in_order(load: Load, name: str) -> None:
    async with seoro.start(load(TICKS), clock="virtual") as run, run.subscribe(name) as events:
        received = [occurrence async for occurrence in events]
    assert received == [(1.0, "main.tick", {"n": 1}), (1.0, "main.tick", {"n": 2}), (2.0, "main.tick", {"n": 3})]
    assert isinstance(received[0], seoro.Occurrence)


async def test_events_of_actors_labels_and_phases(load: Load) -> None:
    external = ["operator_ready", "robot.released"]
    async with (
        seoro.start(load(HANDOVER), clock="virtual", external=external) as run,
        run.subscribe("robot.arrived") as arrivals,
        run.subscribe("ready.end") as ready,
        run.subscribe("end") as ends,
    ):
        assert (await anext(arrivals)).time == 2.0
        await run.emit("operator_ready", name="Ada")
        assert (await anext(ready)).name == "main.ready.end"
        await run.emit("operator_ready", name="Ada")
        await run.emit("robot.released", by="Ada")
        assert [each.name async for each in ends] == ["main.end"]
    assert (await run.result()).passed


async def test_a_subscription_before_the_run_and_one_after_it(load: Load) -> None:
    async with (
        prepare(load(TICKS), Options(clock="virtual")) as run,
        run.subscribe("start") as starts,
        run.running(),
    ):
        assert [each.time async for each in starts] == [0.0]
        await run.result()
        async with run.subscribe("tick") as late:
            assert [each async for each in late] == []


async def test_an_unknown_event_is_refused_with_the_known_ones(load: Load) -> None:
    async with seoro.start(load(HANDOVER), clock="virtual", external=["operator_ready"]) as run:
        with pytest.raises(seoro.UsageError) as caught:
            run.subscribe("robot.left")
        for known in ("`operator_ready`", "`robot.arrived`", "`ready.end`", "`end`"):
            assert known in caught.value.message
        with pytest.raises(seoro.UsageError, match="unknown event `contact`"):
            run.subscribe("contact")


async def test_drop_oldest_counts_dropped_occurrences(load: Load) -> None:
    async with (
        seoro.start(load(TICKS), clock="virtual") as run,
        run.subscribe("tick", capacity=2, on_full="drop_oldest") as events,
    ):
        await run.result()
        assert [each.arguments["n"] async for each in events] == [2, 3]
        assert events.lost == 1


async def test_fail_raises_where_occurrences_are_missing(load: Load) -> None:
    async with seoro.start(load(TICKS), clock="virtual") as run, run.subscribe("tick", capacity=1) as events:
        await run.result()
        assert (await anext(events)).arguments == {"n": 1}
        with pytest.raises(seoro.SubscriptionOverflow, match="2 occurrences were lost") as caught:
            await anext(events)
        assert caught.value.lost == 2


async def test_wait_holds_virtual_time_until_there_is_room(load: Load) -> None:
    async with (
        seoro.start(load(TICKS), clock="virtual", keep_trace=True) as run,
        run.subscribe("tick", capacity=1, on_full="wait") as events,
    ):
        for n, time in ((1, 1.0), (2, 1.0), (3, 2.0)):
            assert (await anext(events)).arguments == {"n": n}
            for _ in range(300):  # far more turns of the loop than the rest of the run would take
                await asyncio.sleep(0)
            assert run.now == time
        assert [each async for each in events] == []
    assert (await run.result()).duration == 3602.0


async def test_a_run_is_stopped_although_a_subscription_holds_time(load: Load) -> None:
    async with (
        seoro.start(load(TICKS), clock="virtual") as run,
        run.subscribe("tick", capacity=1, on_full="wait") as events,
    ):
        await anext(events)
        run.stop()
        assert (await run.result()).status is seoro.RunStatus.CANCELLED


async def test_a_closed_subscription_holds_nothing(load: Load) -> None:
    async with seoro.start(load(TICKS), clock="virtual") as run:
        async with run.subscribe("tick", capacity=1, on_full="wait") as events:
            await anext(events)
        assert (await run.result()).passed
        assert [each.arguments["n"] async for each in events] == [2]


async def test_wait_is_refused_on_the_real_clock(load: Load) -> None:
    async with seoro.start(load(TICKS), clock="real") as run:
        with pytest.raises(seoro.UsageError, match="the real clock cannot be stopped"):
            run.subscribe("tick", on_full="wait")


@pytest.mark.parametrize("arguments", [{"capacity": 0}, {"capacity": "2"}, {"on_full": "block"}])
async def test_invalid_arguments_of_a_subscription(load: Load, arguments: dict[str, Any]) -> None:
    async with seoro.start(load(TICKS), clock="virtual") as run:
        with pytest.raises(seoro.UsageError):
            run.subscribe("tick", **arguments)


# ------------------------------------------------------------ emitting


@pytest.mark.parametrize("clock", ["virtual", "real"])
async def test_an_emission_is_recorded_with_its_origin(load: Load, clock: Literal["virtual", "real"]) -> None:
    text = HANDOVER.replace("elapsed(2s)", "elapsed(1ms)")
    external = ["operator_ready", "robot.released"]
    async with seoro.start(load(text), clock=clock, external=external, keep_trace=True) as run:
        async with run.subscribe("robot.arrived") as events:
            await anext(events)
        emitted = await run.emit("operator_ready", name="Ada", distance=3, light="red")
        await run.emit("operator_ready", name="Ada", light="color!red")
        await run.emit("robot.released", by="Bob")
        verdict = await run.result()
        records = [record async for record in run.trace()]
    assert verdict.passed
    assert records[0]["external"] == ["main.operator_ready", "robot.released"]
    first, second = events_of(records, "main.operator_ready")
    assert first["arguments"] == {"name": "Ada", "distance": 3.0, "light": "color!red"} == emitted.arguments
    assert (first["origin"], first["t"]) == ("application", emitted.time)
    assert second["arguments"]["distance"] == 2.0
    [released] = events_of(records, "robot.released")
    assert released["origin"] == "application"
    assert "origin" not in events_of(records, "main.ask")[0]


async def test_each_emission_has_an_instant_of_its_own(load: Load) -> None:
    """Two `wait` in a row need two instants, and the virtual clock stands still between them."""
    text = "scenario main:\n    event go\n    do serial:\n        wait @go\n        wait @go\n"
    async with seoro.start(load(text), clock="virtual", external=["go"]) as run:
        assert [(await run.emit("go")).time for _ in range(2)] == [1e-9, 2e-9]
        assert (await run.result()).passed


async def test_an_emission_is_not_in_the_past_of_its_receiver(load: Load) -> None:
    text = """import osc.types
scenario main:
    event go
    event ask
    do serial:
        emit go
        emit ask
        wait @go
"""
    async with seoro.start(load(text), clock="virtual", external=["go"]) as run, run.subscribe("ask") as asks:
        await anext(asks)
        await run.emit("go")
        assert (await run.result()).passed


async def test_a_run_waits_for_its_application(load: Load) -> None:
    """Without external events, nothing could happen any more."""
    text = "scenario main:\n    event go\n    do wait @go\n"
    async with seoro.start(load(text), clock="virtual") as run:
        assert (await run.result()).reason.startswith("nothing can happen any more")
    async with seoro.start(load(text), clock="virtual", external=["go"]) as run:
        for _ in range(100):
            await asyncio.sleep(0)
        assert run.verdict is None
        await run.emit("go")
        assert (await run.result()).passed


async def test_emitting_while_a_subscription_holds_time(load: Load) -> None:
    text = """import osc.types
scenario main:
    event ask(n: int)
    event answer(n: int)
    do serial:
        emit ask(1)
        emit ask(2)
        wait @answer
        wait elapsed(1s)
"""
    async with (
        seoro.start(load(text), clock="virtual", external=["answer"]) as run,
        run.subscribe("ask", capacity=1, on_full="wait") as asks,
    ):
        answers = [await run.emit("answer", n=occurrence.arguments["n"]) async for occurrence in asks]
    assert [answer.time for answer in answers] == [1e-9, 2e-9]
    assert (await run.result()).duration == 1.000000001


async def test_struct_and_list_fields(load: Load) -> None:
    text = HANDOVER.replace("ready: wait @operator_ready", "ready: wait @moved")
    async with seoro.start(load(text), clock="virtual", external=["moved"]) as run:
        emitted = await run.emit("moved", to={"x": 1, "label": "gate"}, sizes=[1, 2.5])
    assert emitted.arguments == {"to": {"x": 1.0, "label": "gate"}, "sizes": [1.0, 2.5]}


@pytest.mark.parametrize(
    ("event", "given", "message"),
    [
        ("operator_reddy", {}, "unknown event `operator_reddy` .*`operator_ready`"),
        ("robot.arived", {}, "unknown event `robot.arived` .*`robot.arrived`"),
        ("ask", {}, "`ask` is not external.*external events: `main.operator_ready`, `main.moved`"),
        ("end", {}, "`end` is predefined"),
        ("operator_ready", {}, "missing field `name`.*expected a string"),
        ("operator_ready", {"nam": "Ada"}, "unknown field `nam`.*fields: `name`, `distance`, `light`"),
        ("operator_ready", {"name": 3}, "invalid field `name`.*expected a string, found 3"),
        ("operator_ready", {"name": "a", "distance": "3m"}, r"expected a number in m \(`length`\), found '3m'"),
        ("operator_ready", {"name": "a", "distance": True}, "expected a number in m"),
        ("operator_ready", {"name": "a", "distance": float("nan")}, "that is finite"),
        (
            "operator_ready",
            {"name": "a", "light": "blue"},
            "a member of `color`: red, green, found 'blue'",
        ),
        ("moved", {"to": {"x": 1}, "sizes": []}, "fields of `place`: x, label"),
        ("moved", {"to": {"x": 1, "label": ""}, "sizes": 3}, "expected a list"),
    ],
)
async def test_invalid_emissions_are_rejected(load: Load, event: str, given: dict[str, Any], message: str) -> None:
    async with seoro.start(load(HANDOVER), clock="virtual", external=["operator_ready", "moved"]) as run:
        with pytest.raises(seoro.UsageError, match=message):
            await run.emit(event, **given)


async def test_external_events_have_to_be_declared_by_the_scenario(load: Load) -> None:
    with pytest.raises(seoro.UsageError, match="unknown event `go`"):
        async with seoro.start(load(HANDOVER), clock="virtual", external=["go"]):
            pass
    with pytest.raises(seoro.UsageError, match="`external`"):
        async with seoro.start(load(HANDOVER), clock="virtual", external="operator_ready"):
            pass


async def test_nothing_is_emitted_before_and_after_a_run(load: Load) -> None:
    options = Options(clock="virtual", external=["operator_ready"])
    async with prepare(load(HANDOVER), options) as run:
        with pytest.raises(seoro.UsageError, match="has not started"):
            await run.emit("operator_ready", name="Ada")
        async with run.running():
            run.stop()
            await run.result()
            with pytest.raises(seoro.UsageError, match="the run is over"):
                await run.emit("operator_ready", name="Ada")


async def test_an_emission_that_finds_no_instant_any_more_is_refused(load: Load) -> None:
    async with seoro.start(load(HANDOVER), clock="virtual", external=["operator_ready"]) as run:
        pending = asyncio.create_task(run.emit("operator_ready", name="Ada"))
        run.stop()
        with pytest.raises(seoro.UsageError, match="the run is over"):
            await pending


async def test_an_emission_ends_with_a_run_that_a_defect_breaks(
    load: Load, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*arguments: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr("seoro.runtime.run.Execution._conclude", broken)
    scenario, pending = load(HANDOVER), set[asyncio.Task[seoro.Occurrence]]()
    with pytest.raises(ExceptionGroup) as caught:
        async with seoro.start(scenario, clock="virtual", external=["operator_ready"]) as run:
            pending.add(asyncio.create_task(run.emit("operator_ready", name="Ada")))
            run.stop()
            await asyncio.sleep(3600)
    assert isinstance(cause_of(caught.value), ZeroDivisionError)
    with pytest.raises(seoro.UsageError, match="the run is over"):
        await pending.pop()


async def test_a_cancelled_emission_does_not_occur(load: Load) -> None:
    text = "scenario main:\n    event go\n    event ask\n    do serial:\n        emit ask\n        wait @go\n"
    async with (
        seoro.start(load(text), clock="virtual", external=["go"], keep_trace=True) as run,
        run.subscribe("ask") as asks,
    ):
        await anext(asks)
        pending = asyncio.create_task(run.emit("go"))
        await asyncio.sleep(0)
        pending.cancel()
        with pytest.raises(asyncio.CancelledError):
            await pending
        run.stop()
        await run.result()
        assert events_of([record async for record in run.trace()], "main.go") == []


async def test_external_events_of_an_entry_scenario_that_is_repeated(load: Load) -> None:
    """The events of the present attempt are meant."""
    text = """import osc.helpers
scenario main:
    repeat(2)
    event go
    event ask
    do serial:
        emit ask
        wait @go
"""
    async with seoro.start(load(text), clock="virtual", external=["go"]) as run, run.subscribe("ask") as asks:
        async for _ in asks:
            await run.emit("go")
    assert (await run.result()).passed
