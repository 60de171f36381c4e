"""Traces with emissions of an application: they are accepted, and made again."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, Literal

import pytest

import seoro
from seoro.embed import accept
from tests.embedding.conftest import without_stamps

TEXT = """import osc.types
import osc.helpers

enum light: [red, green]

struct place:
    x: length

actor porter:
    event released(by: string)

scenario main:
    robot: porter
    pause: time = 2s
    event ask
    event go(light: light, to: place, sizes: list of length, who: porter, n: int = 3)
    event never
    do serial:
        wait elapsed(pause)
        parallel:
            serial:
                serial:
                    emit ask
                    wait @go
                    log("went")
                with:
                    repeat(2)
                wait @robot.released
            wait elapsed([1s..9s])
        wait elapsed(1ms)
"""

Load = Callable[[str], seoro.Scenario]
Records = list[dict[str, Any]]
EXTERNAL = ["go", "robot.released", "never"]


async def traced(scenario: seoro.Scenario, clock: Literal["virtual", "real"]) -> Records:
    """The trace of a run with an application."""
    overrides = {"pause": "1ms"}
    async with (
        seoro.start(scenario, seed=3, clock=clock, overrides=overrides, external=EXTERNAL, keep_trace=True) as run,
        run.subscribe("ask") as asks,
    ):
        for light in ("red", "green"):
            await anext(asks)
            await run.emit("go", light=light, to={"x": 1}, sizes=[1, 2], who="robot")
        await run.emit("robot.released", by="Ada")
        assert (await run.result()).passed
        return [json.loads(json.dumps(record)) async for record in run.trace()]


def quick(text: str) -> str:
    return text.replace("[1s..9s]", "[1ms..9ms]")


@pytest.fixture
async def trace(load: Load) -> Records:
    return await traced(load(TEXT), "virtual")


@pytest.mark.parametrize("clock", ["virtual", "real"])
async def test_a_trace_with_emissions_is_accepted(load: Load, clock: Literal["virtual", "real"]) -> None:
    scenario = load(quick(TEXT))
    acceptance = accept(scenario, await traced(scenario, clock))
    assert acceptance.accepted, acceptance.violations


def emitted(records: Records) -> dict[str, Any]:
    return next(record for record in records if record.get("origin"))


def not_declared(records: Records) -> None:
    records[0]["external"] = ["robot.released"]


def without_declarations(records: Records) -> None:
    del records[0]["external"]


def of_nobody(records: Records) -> None:
    del emitted(records)["origin"]


def of_somebody_else(records: Records) -> None:
    emitted(records)["origin"] = "somebody"


def with_other_arguments(records: Records) -> None:
    record = emitted(records)
    for name in ("arguments", "exact"):
        del record[name]["n"]


def of_actor_not_declared(records: Records) -> None:
    records[0]["external"] = ["main.go"]


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (not_declared, "`go` is emitted from outside at .* but is not external"),
        (without_declarations, "is not external in `run.start`"),
        (of_nobody, "occurs at .* without an `emit`"),
        (of_somebody_else, "is not external"),
        (with_other_arguments, "has the arguments .* expected"),
        (of_actor_not_declared, "`released` is emitted from outside"),
    ],
)
async def test_unexpected_external_events_are_not_accepted(
    load: Load, trace: Records, edit: Callable[[Records], None], message: str
) -> None:
    edit(trace)
    violations = accept(load(TEXT), trace).violations
    assert {violation.rule.title for violation in violations} == {"event"}
    with pytest.raises(AssertionError, match=message):
        raise AssertionError("\n".join(violation.message for violation in violations))


async def test_a_replay_gives_the_same_trace(load: Load, trace: Records) -> None:
    async with seoro.replay(load(TEXT), trace, keep_trace=True) as run:
        assert (await run.result()).passed
        again = [json.loads(json.dumps(record)) async for record in run.trace()]
    assert without_stamps(again) == without_stamps(trace)


async def test_a_replay_of_an_entry_scenario_that_is_repeated(load: Load) -> None:
    text = """import osc.helpers
scenario main:
    repeat(3)
    event go
    event ask
    do serial:
        emit ask
        wait @go
"""
    traces: list[Any] = []
    async with (
        seoro.start(load(text), seed=3, clock="virtual", external=["go"], keep_trace=True) as run,
        run.subscribe("ask") as asks,
    ):
        async for _ in asks:
            await run.emit("go")
        traces.append([record async for record in run.trace()])
    async with seoro.replay(load(text), traces[0], keep_trace=True) as run:
        await run.result()
        traces.append([record async for record in run.trace()])
    assert without_stamps(traces[1]) == without_stamps(traces[0])
    assert accept(load(text), traces[0]).accepted


async def test_a_replay_waits_for_no_application(load: Load, trace: Records) -> None:
    shorter = [record for record in trace if record.get("name") != "robot.released"]
    async with seoro.replay(load(TEXT), shorter) as run:
        assert (await run.result()).reason.startswith("nothing can happen any more")


async def test_a_replay_of_an_unknown_event_is_rejected(load: Load, trace: Records) -> None:
    with pytest.raises(seoro.UsageError, match="unknown event"):
        async with seoro.replay(load(TEXT.replace("event never", "event other")), trace):
            pass
    with pytest.raises(seoro.UsageError, match="is not external"):
        async with seoro.start(load(TEXT), replay=trace):
            pass
    with pytest.raises(seoro.UsageError, match="invalid field `by`"):
        async with seoro.replay(load(TEXT.replace("by: string", "by: int")), trace):
            pass
    with pytest.raises(seoro.UsageError, match=r"expected `run\.start`"):
        async with seoro.replay(load(TEXT), []):
            pass
