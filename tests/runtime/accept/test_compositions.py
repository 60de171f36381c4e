"""Compositions: `serial`, `parallel`, `one_of`, the `do` of scenarios, and outcomes."""

import pytest

from tests.runtime.accept.conftest import Traced, TraceText

LOGS = "scenario main:\n    do serial:\n        log('a')\n        log('b')\n"
SERIAL = """
scenario main:
    do serial:
        a: wait elapsed(1s)
        b: wait elapsed(1s)
        log("end")
"""


async def test_a_member_starts_in_the_instant_in_which_its_predecessor_ended(trace_text: TraceText) -> None:
    traced = await trace_text(SERIAL)
    assert traced.broken == set()
    traced.shift(traced.start("b"), 0.5)
    assert "serial" in traced.broken
    assert "`b` starts at 1.5 s; expected 1 s" in traced.messages


async def test_a_missing_member_of_serial_is_rejected(trace_text: TraceText) -> None:
    traced = await trace_text(
        "scenario main:\n    do serial:\n        log('a')\n        log('b')\n        log('c')\n"
    )
    assert traced.broken == set()
    middle = traced.copy()
    middle.drop_behavior("log", 1)
    assert middle.broken == {"serial"}
    assert "`log` is missing" in middle.messages
    traced.drop_behavior("log", 2)
    assert "succeeded before its content has ended" in traced.messages


async def test_members_of_serial_in_another_order_are_rejected(trace_text: TraceText) -> None:
    traced = await trace_text(LOGS)
    first, second = traced.start("log"), traced.start("log", 1)
    first["source"], second["source"] = second["source"], first["source"]
    assert "serial" in traced.broken
    assert "out of order" in traced.messages


async def test_a_member_after_a_failed_one_is_rejected(trace_text: TraceText) -> None:
    traced = await trace_text(SERIAL)
    traced.end("a")["status"] = "failed"
    assert "outcome" in traced.broken
    assert "`b` starts after a member has failed" in traced.messages


async def test_a_failure_despite_successful_members_is_rejected(trace_text: TraceText) -> None:
    traced = await trace_text(
        "scenario main:\n    do serial:\n        serial:\n            log('a')\n        log('b')\n"
    )
    traced.drop_behavior("log", 1)
    for name, number in (("serial", 1), ("serial", 0), ("main", 0)):
        traced.end(name, number)["status"] = "failed"
    traced.find("event", event="end")["event"] = "fail"
    traced.find("run.end")["status"] = "failed"
    assert traced.broken == {"outcome"}
    assert "it failed, but its content succeeded" in traced.messages


async def test_an_unknown_behavior_is_rejected(trace_text: TraceText) -> None:
    traced = await trace_text(SERIAL)
    traced.start("b")["source"] = "test.osc:1:1"
    assert "serial" in traced.broken
    assert "`b` is not a member of it" in traced.messages


async def test_a_run_of_another_scenario_is_rejected(trace_text: TraceText) -> None:
    traced = await trace_text("scenario other:\n    do log('x')\n\nscenario main:\n    do log('x')\n")
    traced.start("main")["name"] = "other"
    assert traced.broken == {"tree"}


async def test_another_invoked_scenario_is_rejected(trace_text: TraceText) -> None:
    others = "scenario a:\n    do log('x')\n\nscenario b:\n    do log('x')\n\n"
    traced = await trace_text(others + "scenario main:\n    do serial:\n        a()\n        b()\n")
    assert traced.broken == set()
    traced.find("instance", of="a")["of"] = "b"
    assert "`b` is invoked; expected `a`" in traced.messages


async def test_a_verdict_that_differs_from_the_scenario_is_rejected(trace_text: TraceText) -> None:
    traced = await trace_text(SERIAL)
    traced.find("run.end")["status"] = "failed"
    assert traced.broken == {"outcome"}


async def test_a_scenario_that_ends_after_its_do_is_rejected(trace_text: TraceText) -> None:
    traced = await trace_text(SERIAL)
    traced.shift(traced.find("event", event="end"), 1.0)
    assert traced.broken == {"direct"}


# ---------------------------------------------------------------- parallel

PARALLEL = """
scenario main:
    do parallel({arguments}):
        a: wait elapsed({a})
        b: wait elapsed({b})
"""


async def parallel(trace_text: TraceText, arguments: str, a: str = "3s", b: str = "2s") -> Traced:
    traced = await trace_text(PARALLEL.format(arguments=arguments, a=a, b=b))
    assert traced.broken == set(), traced.messages
    return traced


async def test_members_of_parallel_start_together(trace_text: TraceText) -> None:
    traced = await parallel(trace_text, "")
    start, label = traced.start("b"), traced.find("event", event="b.start")
    traced.move(start, after=traced.end("b"))
    for record in (traced.end("b"), traced.find("event", event="b.end")):
        traced.move(record, after=start)
    traced.move(label, after=start)
    assert "`b` starts at 2 s; expected 0 s, with the others" in traced.messages


async def test_a_missing_member_of_parallel_is_rejected(trace_text: TraceText) -> None:
    traced = await parallel(trace_text, "")
    traced.drop_behavior("b")
    traced.drop(traced.find("event", event="b.start"), traced.find("event", event="b.end"))
    assert traced.broken == {"parallel"}
    assert "`b` does not start" in traced.messages


async def test_a_parallel_that_ends_before_its_last_member_is_rejected(trace_text: TraceText) -> None:
    traced = await parallel(trace_text, "")
    traced.shift(traced.end("parallel"), 1.0)
    assert "parallel" in traced.broken


async def test_a_member_that_continues_after_a_failure_is_rejected(trace_text: TraceText) -> None:
    traced = await parallel(trace_text, "")
    traced.end("b")["status"] = "failed"
    assert "`a` continues after `b` has failed" in traced.messages


@pytest.mark.parametrize(
    ("overlap", "a", "b", "by"),
    [
        ("equal", "2s", "2s", -1.0),
        ("equal", "2s", "2s", 1.0),
        ("end", "2s", "2s", -1.0),
        ("end", "2s", "2s", 1.0),
        ("final", "2s", "3s", -2.0),
        ("inside", "3s", "2s", 2.0),
        ("full", "2s", "3s", -2.0),
    ],
)
async def test_ends_outside_of_the_overlap_are_rejected(
    trace_text: TraceText, overlap: str, a: str, b: str, by: float
) -> None:
    traced = await parallel(trace_text, f"overlap: {overlap}", a, b)
    # The earlier end is before the other one, which is delayed.
    late, early = ("b", "a") if by > 0 else ("a", "b")
    if traced.end(early)["seq"] > traced.end(late)["seq"]:
        end, event = traced.end(late), traced.find("event", event=f"{late}.end")
        last = traced.find("event", event=f"{early}.end")
        traced.move(end, after=last)
        traced.move(event, after=end)
    traced.shift(traced.end(late), abs(by))
    assert "parallel" in traced.broken, traced.messages


async def test_wrong_offsets_of_starts_are_rejected(trace_text: TraceText) -> None:
    traced = await parallel(trace_text, "start_to_start: 1s")
    assert traced.start("b")["t"] == 1.0
    traced.shift(traced.start("b"), 0.5)
    assert "`b` starts 1.5 s after the primary member" in traced.messages
    negative = await parallel(trace_text, "start_to_start: [-2s..-1s]")
    negative.shift(negative.start("a"), 1.0)
    assert "parallel" in negative.broken


async def test_wrong_offsets_of_ends_are_rejected(trace_text: TraceText) -> None:
    traced = await parallel(trace_text, "end_to_end: -1s")
    traced.shift(traced.end("a"), 1.0)
    assert "parallel" in traced.broken


async def test_a_failure_without_a_cause_is_rejected(trace_text: TraceText) -> None:
    traced = await parallel(trace_text, "overlap: inside")
    traced.end("parallel")["status"] = "failed"
    assert "outcome" in traced.broken


# ---------------------------------------------------------------- one_of

ONE_OF = """
scenario main:
    do one_of:
        serial:
            wait elapsed(1s)
            log("guarded")
        wait elapsed(3s)
        serial:
            log("first")
            late: wait elapsed(2s)
"""


async def test_one_of_continues_with_one_member(trace_text: TraceText) -> None:
    traced = await trace_text(ONE_OF)
    assert traced.broken == set(), traced.messages
    traced.end("late")["status"] = "succeeded"
    traced.end("serial", 1)["status"] = "succeeded"
    assert "one_of" in traced.broken
    assert "continues after its guard, but" in traced.messages


async def test_a_member_that_continues_after_the_decision_is_rejected(trace_text: TraceText) -> None:
    traced = await trace_text(ONE_OF.replace('log("guarded")', "wait elapsed(1s)"))
    assert traced.broken == set(), traced.messages
    end = next(
        traced.end("wait", number) for number in range(3) if traced.end("wait", number)["status"] == "cancelled"
    )
    traced.move(end, after=next(record for record in traced.records if record["t"] == 2.0))
    assert "is still running after" in traced.messages


async def test_two_invoked_members_of_one_of_are_rejected(trace_text: TraceText) -> None:
    traced = await trace_text("scenario main:\n    do one_of:\n        log('a')\n        log('b')\n")
    assert traced.broken == set()
    [ran] = [record for record in traced.records if record["kind"] == "behavior.start" and record["name"] == "log"]
    other = {**ran, "id": 9, "source": ran["source"].replace(":7:", ":8:").replace(":6:", ":7:")}
    if other["source"] == ran["source"]:
        other["source"] = ran["source"].replace(":8:", ":7:")
    end = traced.end("log")
    traced.insert(end, **other)
    traced.insert(traced.find("behavior.start", id=9), kind="behavior.end", id=9, status="succeeded", reason="")
    assert "one_of" in traced.broken


async def test_one_of_without_an_invoked_member_is_rejected(trace_text: TraceText) -> None:
    traced = await trace_text(
        "scenario main:\n    do one_of:\n        wait elapsed(1s)\n        wait elapsed(2s)\n"
    )
    assert traced.broken == set()
    traced.drop_behavior("wait", 1)
    assert "does not wait" in traced.messages


async def test_a_next_member_without_a_failure_is_rejected(trace_text: TraceText) -> None:
    text = """
scenario main:
    do one_of:
        compare(1, "==", 2)
        compare(1, "==", 3)
"""
    traced = await trace_text(text)
    assert traced.broken == set()
    traced.end("compare")["status"] = "succeeded"
    assert "one_of" in traced.broken


async def test_a_parallel_with_offsets_may_be_ended_before_a_member_has_started(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario main:
    do serial:
        parallel(overlap: any, start_to_start: [-1s..2s]):
            wait elapsed(1s)
            wait elapsed(1s)
        with:
            until elapsed(0s)
""")
    assert traced.find("run.end")["status"] == "passed"
    assert traced.broken == set(), traced.messages


async def test_a_guarded_member_may_be_ended_before_its_guard_fires(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario main:
    event one
    do one_of:
        wait @one
        serial:
            wait @one
        with:
            until elapsed(1s)
""")
    assert traced.broken == set(), traced.messages


@pytest.mark.parametrize("first", ["wait @one", "wait elapsed(2s)", "serial:\n            wait elapsed(2s)"])
async def test_members_of_one_of_prevented_by_an_override_are_accepted(trace_text: TraceText, first: str) -> None:
    traced = await trace_text(f"""
scenario main:
    event one
    do a: one_of:
        b: log("b")
        c: {first}
    with:
        override(b, a, when_active)
        override(c, a, when_active)
""")
    assert [record["name"] for record in traced.records if record["kind"] == "behavior.start"] == ["main", "a"]
    assert traced.broken == set(), traced.messages


async def test_an_overridden_member_of_one_of_decides(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario main:
    do parallel:
        a: one_of:
            b: wait_long()
            c: wait_long()
        serial:
            wait elapsed(1s)
            d: log("d")
        wait elapsed(2s)
    with:
        override(b, d)
        override(c, d)
scenario wait_long:
    do wait elapsed(5s)
""")
    assert traced.end("a")["t"] == 1.0
    assert traced.broken == set(), traced.messages


@pytest.mark.parametrize("operator", ["parallel", "one_of"])
async def test_members_are_cancelled_with_the_composition(trace_text: TraceText, operator: str) -> None:
    traced = await trace_text(f"""
scenario main:
    do serial:
        {operator}:
            a: wait elapsed(5s)
            b: wait elapsed(5s)
        with:
            until elapsed(2s)
""")
    assert traced.broken == set(), traced.messages
    traced.move(traced.end("a"), after=traced.find("event", event="b.start"))
    assert operator in traced.broken
    assert "`a` is cancelled at 0 s, but all of it at 2 s" in traced.messages


async def test_members_are_cancelled_when_another_is_chosen(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario main:
    do parallel:
        one_of:
            wait elapsed(2s)
            a: wait elapsed(3s)
        b: wait elapsed(1s)
""")
    assert traced.broken == set(), traced.messages
    traced.move(traced.end("a"), after=traced.end("b"))
    assert traced.broken == {"one_of"}
