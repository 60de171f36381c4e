"""Events of other objects, and events derived from events or conditions (7.3.10.2, 7.3.10.4)."""

from __future__ import annotations

import pytest

from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import RunText


async def test_the_context_of_a_derived_event_starts_with_each_use(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event late is elapsed(2s)
    do parallel:
        serial:
            wait @late
            log("first")
            wait @late
            log("again")
        serial:
            wait elapsed(1s)
            wait @late
            log("later")
""")
    assert ran.logs == [(2.0, "first"), (3.0, "later"), (4.0, "again")]


async def test_derived_events_may_be_derived_from_and_emitted(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    var n: int = 0
    event go
    event second is @go if n == 1
    event third is @second if n == 1
    do parallel:
        serial:
            wait @third
            log("derived")
            wait @third
            log("emitted")
        serial:
            emit go
            wait elapsed(1s)
            increment(n)
            emit go
            wait elapsed(1s)
            emit third
""")
    assert ran.logs == [(1.0, "derived"), (2.0, "emitted")]
    names = [(r["t"], r["name"]) for r in ran.records if r["kind"] == "event"]
    assert names.count((1.0, "main.third")) == 1, "derived events are in the trace"


async def test_an_occurrence_consumed_through_a_derived_event_is_past(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event go
    event derived is @go
    do parallel:
        serial:
            wait @derived
            wait @go
            log("next")
        serial:
            emit go
            wait elapsed(1s)
            emit go
""")
    assert ran.logs == [(1.0, "next")]


async def test_structs_and_actors_have_their_own_events(run_text: RunText) -> None:
    ran = await run_text("""
struct timer:
    period: time
    event ding is elapsed(period)
actor cart:
    clock: timer = timer(period: 3s)
    var load: int = 0
    event full is load == 2
scenario main:
    a: cart
    b: cart
    short: timer = timer(period: 1s)
    do parallel:
        serial:
            wait @a.full
            log("a is full")
        serial:
            wait @b.full
            log("b is full")
        serial:
            wait @b.clock.ding
            log("b rings")
        serial:
            wait @short.ding
            log("short")
        serial:
            increment(b.load)
            increment(b.load)
            wait elapsed(2s)
            increment(a.load)
            increment(a.load)
""")
    assert ran.logs == [(0.0, "b is full"), (1.0, "short"), (2.0, "a is full"), (3.0, "b rings")]


async def test_a_label_is_its_last_invocation(run_text: RunText) -> None:
    ran = await run_text("""
scenario worker:
    pause: time
    event ready
    event late is elapsed(pause)
    do serial:
        wait elapsed(pause)
        emit ready
        wait elapsed(1s)
scenario pair:
    do inner: worker(2s)
scenario main:
    do parallel:
        serial:
            wait elapsed(1s)
            w: worker(1s)
        serial:
            p: pair()
        serial:
            wait @w.ready
            log("ready")
        serial:
            wait elapsed(1.5s)
            wait @w.late
            log("late")
        serial:
            wait @p.inner.ready
            log("inner")
        serial:
            wait @p.inner.end
            log("inner ended")
""")
    assert sorted(ran.logs) == [(2.0, "inner"), (2.0, "ready"), (2.5, "late"), (3.0, "inner ended")]


async def test_a_condition_on_an_event_of_an_invocation_uses_its_arguments(run_text: RunText) -> None:
    ran = await run_text("""
scenario worker:
    event done(part: int)
    do serial:
        emit done(1)
        wait elapsed(1s)
        emit done(2)
scenario main:
    limit: int = 2
    do parallel:
        w: worker()
        serial:
            wait @w.done as which if which.part == limit
            log("two")
""")
    assert ran.logs == [(1.0, "two")]


@pytest.mark.parametrize("event", ["derived", "never"])
async def test_impossible_events_are_reported(run_text: RunText, event: str) -> None:
    verdict = (
        await run_text(f"""
scenario main:
    var n: int = 0
    event never
    event derived is n > 0
    do wait @{event}
""")
    ).verdict
    assert verdict.status is RunStatus.FAILED
    assert f"still waiting for: `wait @{event}`" in verdict.reason


async def test_coverage_is_sampled_at_derived_events(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event tick is every(1s)
    event late is @tick
    var n: int = 0
    record(count, expression: n, event: late)
    do serial:
        wait elapsed(0.5s)
        increment(n)
        wait elapsed(1s)
""")
    sampled = [(r["t"], r["item"], r["value"]) for r in ran.records if r["kind"] == "record"]
    assert sampled == [(0.0, "count", 0), (1.0, "count", 1)]
