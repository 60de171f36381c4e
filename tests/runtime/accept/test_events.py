"""`wait`, `until`, `duration`, `emit`, events, `on` and `sample`."""

import pytest

from tests.runtime.accept.conftest import Traced, TraceText


async def accepted(trace_text: TraceText, text: str) -> Traced:
    traced = await trace_text(text)
    assert traced.broken == set(), traced.messages
    return traced


def end_later(traced: Traced, name: str, by: float = 1.0) -> None:
    """Delay the end of a behavior, and all later records."""
    traced.shift(traced.end(name), by)


# ---------------------------------------------------------------- wait

WAITS = [
    ("elapsed(2s)", ""),
    ("elapsed([1s..2s])", ""),
    ("@go", ""),
    ("@go as g if g.n > 1", ""),
    ("@w.end", ""),
    ("x > 1", ""),
    ("rise(x > 1)", ""),
    ("fall(x < 2)", ""),
    ("@go if x > 1", ""),
    ("every(2s, offset: 2s)", ""),
    ("@derived", ""),
]
WAIT = """
scenario main:
    event go(n: int)
    event derived is @go if x > 1
    var x: int = 0
    do parallel:
        it_waits: wait {event}
        serial:
            w: wait elapsed(2s)
            increment(x)
            increment(x)
            emit go(n: x)
            wait elapsed(1s)
        wait elapsed(4s)
"""


@pytest.mark.parametrize("event", [event for event, _ in WAITS])
async def test_a_wait_does_not_end_before_its_event(trace_text: TraceText, event: str) -> None:
    traced = await accepted(trace_text, WAIT.format(event=event))
    first = traced.find("behavior.start", name="wait")
    end = traced.end("it_waits")
    label = traced.find("event", event="it_waits.end")
    traced.move(end, after=first)
    traced.move(label, after=end)
    assert "wait" in traced.broken, traced.messages


@pytest.mark.parametrize("event", [event for event, _ in WAITS])
async def test_a_wait_does_not_last_beyond_its_event(trace_text: TraceText, event: str) -> None:
    traced = await accepted(trace_text, WAIT.format(event=event))
    end, label = traced.end("it_waits"), traced.find("event", event="it_waits.end")
    last = next(record for record in traced.records if record["t"] == 3.0)
    traced.move(end, after=last)
    traced.move(label, after=end)
    assert "wait" in traced.broken, traced.messages


async def test_a_wait_does_not_receive_emissions_of_its_own_task(trace_text: TraceText) -> None:
    text = """
scenario main:
    event go
    do one_of:
        serial:
            emit go
            it_waits: wait @go
        serial:
            wait elapsed(2s)
            log("over")
"""
    traced = await accepted(trace_text, text)
    end = traced.end("it_waits")
    assert end["status"] == "cancelled"
    end["status"] = "succeeded"
    traced.move(end, after=traced.find("event", event="it_waits.start"))
    assert "wait" in traced.broken


async def test_a_wait_does_not_receive_a_consumed_occurrence_again(trace_text: TraceText) -> None:
    text = """
scenario main:
    event go
    do one_of:
        serial:
            log("begin")
            parallel:
                emit go
                serial:
                    first: wait @go
                    second: wait @go
        serial:
            wait elapsed(2s)
            log("over")
"""
    traced = await accepted(trace_text, text)
    end = traced.end("second")
    assert end["status"] == "cancelled"
    end["status"] = "succeeded"
    traced.move(end, after=traced.find("event", event="second.start"))
    assert "wait" in traced.broken


async def test_a_wait_that_misses_an_emission_of_another_task_is_rejected(trace_text: TraceText) -> None:
    text = """
scenario main:
    event go
    do parallel:
        serial:
            emit go
            wait elapsed(1s)
        it_waits: wait @go
"""
    traced = await accepted(trace_text, text)
    end, label = traced.end("it_waits"), traced.find("event", event="it_waits.end")
    traced.move(end, after=traced.end("serial"))
    traced.move(label, after=end)
    assert "wait" in traced.broken


async def test_a_failed_wait_is_rejected(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, WAIT.format(event="elapsed(1s)"))
    traced.end("it_waits")["status"] = "failed"
    assert "a `wait` cannot fail" in traced.messages


# ---------------------------------------------------------------- until, duration

UNTIL = """
scenario main:
    event go
    do parallel:
        serial:
            wait elapsed(2s)
            emit go
            wait elapsed(2s)
        ended: serial:
            wait elapsed({work})
        with:
            until {event}
"""


@pytest.mark.parametrize("work", ["1s", "9s"])
@pytest.mark.parametrize("event", ["@go", "elapsed(2s)"])
async def test_until_ends_exactly_at_its_event(trace_text: TraceText, event: str, work: str) -> None:
    traced = await accepted(trace_text, UNTIL.format(event=event, work=work))
    late = traced.copy()
    end, label = late.end("ended"), late.find("event", event="ended.end")
    late.move(end, after=late.end("wait", 2))
    late.move(label, after=end)
    assert "until" in late.broken, late.messages
    if work == "1s":
        inner = traced.end("wait", 1)
        end, label = traced.end("ended"), traced.find("event", event="ended.end")
        traced.move(end, after=inner)
        traced.move(label, after=end)
        assert "until" in traced.broken, traced.messages


DURATION = """
scenario main:
    do parallel:
        lasts: serial(duration: {duration}):
            wait elapsed(1s)
        wait elapsed(5s)
"""


async def test_a_duration_has_bounds(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, DURATION.format(duration="[2s..3s]"))
    assert traced.end("lasts")["t"] == 2.0
    end, label = traced.end("lasts"), traced.find("event", event="lasts.end")
    late = traced.copy()
    end, label = late.end("lasts"), late.find("event", event="lasts.end")
    late.move(end, after=late.end("wait", 0 if late.end("wait")["t"] == 5.0 else 1))
    late.move(label, after=end)
    assert "duration" in late.broken
    end, label = traced.end("lasts"), traced.find("event", event="lasts.end")
    traced.move(end, after=next(record for record in traced.records if record["t"] == 1.0))
    traced.move(label, after=end)
    assert "duration" in traced.broken


# ---------------------------------------------------------------- emit, and where events come from

EVENTS = """
scenario inner:
    event ready(n: int)
    do serial:
        wait elapsed(1s)
        emit ready(n: 3)

scenario main:
    do serial:
        a: inner()
        log("x")
"""


async def test_emitted_events_occur(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, EVENTS)
    traced.drop(traced.find("event", event="ready"))
    assert traced.broken == {"emit"}


async def test_emitted_events_occur_with_their_arguments(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, EVENTS)
    traced.find("event", event="ready").update(exact={"n": 4}, arguments={"n": 4})
    assert {"emit", "event"} <= traced.broken


async def test_events_have_the_declared_arguments(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, EVENTS)
    traced.find("event", event="ready")["arguments"] = {"m": 3}
    assert "expected ['n']" in traced.messages


async def test_occurrences_have_an_emission(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, EVENTS)
    event = traced.find("event", event="ready")
    traced.insert(traced.find("event", event="start", of=event["of"]), **event | {"wall": ""})
    traced.records[event["seq"]]["t"] = event["t"]
    assert "event" in traced.broken
    assert "without an `emit`" in traced.messages


async def test_an_event_occurs_once_in_an_instant(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, EVENTS)
    event = traced.find("event", event="ready")
    traced.insert(event, **event)
    assert "`ready` occurs twice at 1 s" in traced.messages


@pytest.mark.parametrize("name", ["a.start", "a.end", "start", "end"])
async def test_labels_and_scenarios_have_their_events(trace_text: TraceText, name: str) -> None:
    traced = await accepted(trace_text, EVENTS)
    traced.drop(traced.find("event", event=name))
    assert traced.broken == {"event"}
    assert f"`{name}` does not occur" in traced.messages


async def test_a_fail_event_of_a_success_is_rejected(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, EVENTS)
    traced.find("event", event="a.end")["event"] = "a.fail"
    assert traced.broken == {"event"}


async def test_emit_end_ends_its_scenario(trace_text: TraceText) -> None:
    text = """
scenario inner:
    do parallel:
        serial:
            wait elapsed(1s)
            emit end
        wait elapsed(3s)

scenario main:
    do inner()
"""
    traced = await accepted(trace_text, text)
    failed = traced.copy()
    failed.end("inner")["status"] = "failed"
    assert "emit" in failed.broken
    traced.shift(traced.end("wait"), 2.0)
    assert "its scenario continues until 3 s" in traced.messages


async def test_emit_takes_no_time(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, EVENTS)
    traced.shift(traced.end("emit"), 1.0)
    assert "it takes 1 s; expected no time" in traced.messages


async def test_a_derived_event_occurs_with_its_source(trace_text: TraceText) -> None:
    text = """
scenario main:
    event go
    event again is @go
    do parallel:
        serial:
            wait elapsed(1s)
            emit go
        wait @again
"""
    traced = await accepted(trace_text, text)
    derived = traced.find("event", event="again")
    assert derived["derived"]
    moved, elsewhere = traced.copy(), traced.copy()
    moved.move(moved.find("event", event="again"), after=moved.start("parallel"))
    assert "its source does not" in moved.messages
    elsewhere.find("event", event="again")["event"] = "go"
    assert "is neither emitted nor derived" in elsewhere.messages


# ---------------------------------------------------------------- on, sample

ON = """
scenario main:
    event go
    event answer
    var seen: float = 0.0
    on @go:
        emit answer
    do serial:
        wait elapsed(1s)
        emit go
        wait elapsed(1s)
"""


async def test_on_reacts_to_each_occurrence(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, ON)
    answer = next(r for r in traced.records if r["kind"] == "behavior.start" and "/on[" in r["path"])
    traced.drop(answer, traced.find("behavior.end", id=answer["id"]), traced.find("event", event="answer"))
    assert traced.broken == {"on"}
    assert "it reacts not at 1 s, but its event occurs once" in traced.messages


async def test_on_does_not_react_without_an_occurrence(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, ON)
    answer = next(r for r in traced.records if r["kind"] == "behavior.start" and "/on[" in r["path"])
    end, event = traced.find("behavior.end", id=answer["id"]), traced.find("event", event="answer")
    traced.move(answer, after=traced.start("wait"))
    traced.move(event, after=answer)
    traced.move(end, after=event)
    assert traced.broken == {"on"}


async def test_reactions_take_no_time(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, ON)
    answer = next(r for r in traced.records if r["kind"] == "behavior.start" and "/on[" in r["path"])
    traced.move(traced.find("behavior.end", id=answer["id"]), after=traced.end("wait", 1))
    assert traced.broken == {"emit"}


SAMPLE = """
scenario main:
    event go
    var n: int = 0
    var seen: int = sample(n, @go)
    do serial:
        increment(n)
        wait elapsed(1s)
        emit go
        wait elapsed(1s)
"""


async def test_a_sampled_variable_takes_its_value_at_its_event(trace_text: TraceText) -> None:
    traced = await accepted(trace_text, SAMPLE)
    wrong, missing = traced.copy(), traced.copy()
    wrong.rewrite(7, field="seen")
    assert wrong.broken == {"sample"}
    missing.drop(missing.find("variable", field="seen"))
    assert missing.broken == {"sample"}
    traced.move(traced.find("variable", field="seen"), after=traced.start("wait"))
    assert traced.broken == {"sample"}


async def test_a_held_scenario_samples_no_more_variables(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario worker:
    var taken: int = sample(taken + 1, every(0.7s), 0)
    do wait elapsed(1s)
scenario main:
    event go
    do parallel:
        worker() with:
            until @go
        serial:
            wait elapsed(3s)
            emit go
""")
    assert traced.broken == set(), traced.messages
    traced.drop(traced.find("variable", 1))
    assert traced.broken == {"sample"}


@pytest.mark.parametrize(
    "event", ["@e as x if x.k > 0", "@e as x if true", "@f as x if x.k > 0"], ids=["condition", "name", "several"]
)
async def test_a_variable_is_sampled_from_the_named_occurrence(event: str, trace_text: TraceText) -> None:
    traced = await accepted(
        trace_text,
        f"""
scenario main:
    event e(k: int)
    event f(k: int)
    var k: int = sample(x.k + 1, {event}, 0)
    do serial:
        wait elapsed(1s)
        parallel:
            emit e(2)
            emit f(4)
            emit f(5)
""",
    )
    traced.rewrite(7, field="k")
    assert traced.broken == {"sample"}


@pytest.mark.parametrize("listener", ["wait @d", "wait @later", "slow() with:\n            until @d"])
async def test_a_derived_event_that_ends_a_behavior_is_in_the_trace(listener: str, trace_text: TraceText) -> None:
    traced = await accepted(
        trace_text,
        f"""
scenario slow:
    do wait elapsed(9s)
scenario main:
    event e
    event d is @e
    event later is @d
    do parallel:
        {listener}
        serial:
            wait elapsed(1s)
            emit e
""",
    )
    traced.drop(traced.find("event", event="d"))
    assert traced.broken == {"event"}
