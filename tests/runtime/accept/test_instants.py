"""Events within one instant, and other correct traces that look wrong."""

import pytest

from tests.runtime.accept.conftest import TraceText


async def test_a_behavior_cancelled_before_its_start_has_no_end_event(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario worker:
    do wait elapsed(1s)
scenario main:
    do serial:
        worker() with:
            until every(0.7s)
        a: worker() with:
            until elapsed(0.5s)
""")
    worker = traced.find("instance", of="worker")["instance"]
    assert not [record for record in traced.records if record["kind"] == "event" and record["of"] == worker]
    assert traced.broken == set(), traced.messages
    begun = traced.find("instance", 1, of="worker")["instance"]
    traced.drop(traced.find("event", of=begun, event="end"))
    assert traced.broken == {"event"}


@pytest.mark.parametrize("condition", ["rise(a.n > 0)", "a.n > 0"])
@pytest.mark.parametrize("is_first", [True, False])
async def test_an_instance_invoked_in_the_cycle_of_a_wait_exists_in_the_next_one(
    trace_text: TraceText, condition: str, is_first: bool
) -> None:
    members = ["a: worker(2)", f"wait {condition}"]
    lines = "\n".join(f"            {member}" for member in (members if is_first else members[::-1]))
    traced = await trace_text(f"""
scenario worker:
    n: int
    do wait elapsed(1s)
scenario main:
    do serial:
        parallel:
{lines}
        wait elapsed(1s)
""")
    assert traced.end("wait")["t"] == 0.0
    assert traced.broken == set(), traced.messages


async def test_a_condition_rises_at_the_start_of_its_label(
    trace_text: TraceText,
) -> None:
    traced = await trace_text("""
scenario worker:
    n: int
    do wait elapsed(1s)
scenario main:
    do parallel:
        a: worker(2)
        serial:
            wait elapsed(0.5s)
            b: wait rise(a.n > 0)
    with:
        timeout(2s)
""")
    assert traced.broken == set(), traced.messages
    end = traced.end("b")
    traced.move(end, after=traced.start("b"))
    end["status"] = "succeeded"
    assert "wait" in traced.broken


@pytest.mark.parametrize("modifiers", ["inverter()", "retry(2)", "repeat(2)", "inverter(), timeout(5s)"])
async def test_members_of_parallel_receive_events_of_each_other_within_modifiers(
    trace_text: TraceText, modifiers: str
) -> None:
    lines = "\n".join(f"            {modifier}" for modifier in modifiers.split(", "))
    traced = await trace_text(f"""
scenario main:
    event one
    do serial:
        parallel:
            emit one
            wait @one
        with:
{lines}
    with:
        failure_is_success()
""")
    assert traced.find("run.end")["t"] == 0.0
    assert traced.broken == set(), traced.messages


TICKS = """
scenario worker:
    event tick is every(1s, offset: 1s)
    do wait elapsed(2s)
scenario main:
    var ticks: int = sample(ticks + 1, @a.tick, 0)
    do serial:
        wait elapsed(0.5s)
        a: worker() with:
            repeat(2)
"""


async def test_a_derived_event_of_a_label_has_the_context_of_its_use(trace_text: TraceText) -> None:
    traced = await trace_text(TICKS)
    changes = [record["t"] for record in traced.records if record["kind"] == "variable"]
    assert changes == [1.0, 2.0, 3.0, 4.0]
    assert traced.broken == set(), traced.messages
    moved, missing = traced.copy(), traced.copy()
    missing.drop(missing.find("variable", 1))
    assert missing.broken == {"sample"}
    moved.find("variable", 3)["t"] = 4.25
    assert "sample" in moved.broken


async def test_a_time_from_before_the_start_of_a_label_counts(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario worker:
    event late is elapsed(1s)
    do wait elapsed(2s)
scenario main:
    do parallel:
        serial:
            wait elapsed(3s)
            a: worker()
        b: wait @a.late
""")
    assert traced.end("b")["t"] == 3.0
    assert traced.broken == set(), traced.messages


async def test_the_next_attempt_of_a_parallel_does_not_receive_the_end_of_the_last(
    trace_text: TraceText,
) -> None:
    traced = await trace_text("""
scenario main:
    event one
    event two
    do parallel:
        parallel:
            parallel:
                wait elapsed(0.5s)
            with:
                until @two
            wait @one
        with:
            repeat(2)
        serial:
            wait elapsed(1s)
            emit one
            wait elapsed(1s)
            emit two
            wait elapsed(1s)
            emit one
            emit two
""")
    assert traced.find("run.end")["t"] == 3.0
    assert traced.broken == set(), traced.messages


async def test_an_overridden_held_behavior_samples_no_more(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario worker:
    var ticks: int = sample(ticks + 1, every(0.5s), 0)
    do a: parallel:
        wait elapsed(5s)
        serial:
            wait elapsed(1.25s)
            b: wait elapsed(5s)
    with:
        override(a, b)
scenario main:
    do worker(duration: 3s)
""")
    changes = [record["t"] for record in traced.records if record["kind"] == "variable"]
    assert changes == [0.0, 0.5, 1.0]
    assert traced.broken == set(), traced.messages
    traced.drop(traced.find("variable", 2))
    assert traced.broken == {"sample"}


async def test_a_sample_and_a_variable_of_a_condition_change_in_one_cycle(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario main:
    event go
    var n: int = 0
    var seen: int = sample(n, @go, 0)
    var taken: int = sample(n + 1, n >= 1 and seen < 2, 0)
    do parallel:
        one_of:
            increment(n)
        serial:
            wait elapsed(1s)
            emit go
            wait elapsed(1s)
""")
    changes = [record for record in traced.records if record["kind"] == "variable"]
    assert [(each["t"], each["field"]) for each in changes] == [(0.0, "n"), (0.0, "taken"), (1.0, "seen")]
    assert changes[0]["seq"] + 1 == changes[1]["seq"]
    assert traced.broken == set(), traced.messages


async def test_a_behavior_cancelled_before_its_start_may_be_repeated(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario worker:
    do wait elapsed(1s)
scenario main:
    event one
    do parallel:
        serial:
            wait elapsed(1s)
            serial:
                worker() with:
                    repeat(2)
                    until @one
        serial:
            wait elapsed(1s)
            emit one
            wait elapsed(0.5s)
            emit one
""")
    worker = traced.find("instance", of="worker")["instance"]
    assert [r["event"] for r in traced.records if r["kind"] == "event" and r["of"] == worker] == ["start", "end"]
    assert len([record for record in traced.records if record["kind"] == "attempt.end"]) == 2
    assert traced.broken == set(), traced.messages


async def test_an_attempt_receives_its_own_occurrences_after_similar_ones(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario worker:
    event reported
    do emit reported
scenario main:
    do parallel:
        serial:
            a: worker()
            wait elapsed(5s)
        with:
            repeat(2)
            until @a.reported
        wait elapsed(1s)
""")
    assert traced.find("run.end")["t"] == 1.0
    assert traced.broken == set(), traced.messages


async def test_an_attempt_receives_the_start_of_its_own_member(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario main:
    do serial:
        parallel:
            a: serial:
                wait elapsed(5s)
            with:
                until @b.start
            b: wait elapsed(1s)
        with:
            repeat(2)
""")
    assert traced.find("run.end")["t"] == 2.0
    assert [traced.end("a", number)["t"] for number in (0, 1)] == [0.0, 1.0]
    assert traced.broken == set(), traced.messages
