"""The modifiers of `osc.helpers`, `override`, modifiers of libraries, actions that clean up."""

import pytest

from seoro import ActionContext, Child, ModifierContext, Outcome, action, modifier
from tests.runtime.accept.conftest import Traced, TraceText

MODIFIED = """
scenario main:
    do serial:
        compare(1, "==", {right}) with:
            {modifier}
        log("x")
"""


async def modified(trace_text: TraceText, modifier: str, right: int = 1) -> Traced:
    traced = await trace_text(MODIFIED.format(modifier=modifier, right=right))
    assert traced.broken == set(), traced.messages
    return traced


def modifier_end(traced: Traced) -> dict[str, object]:
    start = traced.find("behavior.start", type="modifier")
    return traced.find("behavior.end", id=start["id"])


async def test_repeat_makes_all_its_attempts(trace_text: TraceText) -> None:
    traced = await modified(trace_text, "repeat(3)")
    traced.drop(traced.find("attempt.start", 2), traced.find("attempt.end", 2), traced.find("instance", 3))
    assert traced.broken == {"modifier"}
    assert "ends after 2 attempts; expected 3" in traced.messages


async def test_repeat_makes_no_more_than_its_attempts(trace_text: TraceText) -> None:
    traced = await modified(trace_text, "repeat(3)")
    traced.find("behavior.start", type="modifier")["arguments"]["count"] = 2
    assert "makes 3 attempts; expected 2" in traced.messages
    assert "`count` differs from the argument of the modifier" in traced.messages


async def test_repeat_ends_with_a_failure(trace_text: TraceText) -> None:
    traced = await modified(trace_text, "repeat(3)")
    traced.find("attempt.end", 0)["status"] = "failed"
    assert "continues after an attempt that failed" in traced.messages


async def test_retry_ends_with_a_success(trace_text: TraceText) -> None:
    traced = await modified(trace_text, "retry(3)", right=2)
    traced.find("attempt.end", 1)["status"] = "succeeded"
    assert "continues after an attempt that succeeded" in traced.messages


async def test_attempts_follow_each_other_at_once(trace_text: TraceText) -> None:
    text = "scenario main:\n    do serial:\n        wait elapsed(1s)\n    with:\n        repeat(2)\n"
    traced = await trace_text(text)
    assert traced.broken == set()
    traced.shift(traced.find("attempt.start", 1), 0.5)
    assert traced.broken == {"modifier"}


@pytest.mark.parametrize("right", [1, 2])
@pytest.mark.parametrize(
    "name", ["inverter()", "failure_is_success()", "success_is_failure()", "timeout(1s)", "running_is_failure()"]
)
async def test_the_outcome_of_a_modifier_follows_from_its_behavior(
    trace_text: TraceText, name: str, right: int
) -> None:
    traced = await modified(trace_text, name, right)
    end = modifier_end(traced)
    end["status"] = "failed" if end["status"] == "succeeded" else "succeeded"
    assert "modifier" in traced.broken


async def test_a_timeout_comes_at_its_time(trace_text: TraceText) -> None:
    text = """
scenario main:
    do serial:
        waits: serial:
            wait elapsed(5s)
        with:
            timeout({limit})
        log("x")
"""
    traced = await trace_text(text.format(limit="2s"))
    assert traced.broken == set(), traced.messages
    for by in (1.0, -1.0):
        moved = traced.copy()
        moved.shift(moved.end("wait"), by)
        assert "modifier" in moved.broken, by


async def test_the_end_of_run_forever_is_rejected(trace_text: TraceText) -> None:
    text = """
scenario main:
    do parallel(overlap: inside):
        wait elapsed(2s)
        serial:
            log("x")
        with:
            success_is_running()
"""
    traced = await trace_text(text)
    assert traced.broken == set(), traced.messages
    modifier_end(traced)["status"] = "succeeded"
    assert "modifier" in traced.broken


async def test_a_missing_modifier_is_rejected(trace_text: TraceText) -> None:
    traced = await modified(trace_text, "inverter()", right=2)
    start = traced.find("behavior.start", type="modifier")
    traced.drop(
        start,
        traced.find("behavior.end", id=start["id"]),
        traced.find("attempt.start"),
        traced.find("attempt.end"),
    )
    assert "modifier" in traced.broken


async def test_effects_of_libraries_are_reported_as_unchecked(trace_text: TraceText, tmp_path: object) -> None:
    @modifier("twice")
    async def twice(ctx: ModifierContext, child: Child) -> Outcome:
        await child.run()
        outcome = await child.run()
        assert outcome is not None
        return outcome

    text = 'modifier twice\n\nscenario main:\n    do log("x") with:\n        twice()\n'
    traced = await trace_text(text, actions=[twice])
    assert traced.broken == set(), traced.messages
    [unchecked] = traced.accept().unchecked
    assert unchecked.reason == "`twice` is implemented in Python with unknown rules"


# ---------------------------------------------------------------- override

OVERRIDE = """
scenario main:
    do parallel:
        serial:
            a: wait elapsed(3s)
            log("after a")
        serial:
            wait elapsed(1s)
            b: wait elapsed(4s)
    with:
        override(a, b)
"""


async def test_an_overridden_behavior_ends_when_the_other_starts(trace_text: TraceText) -> None:
    traced = await trace_text(OVERRIDE)
    assert traced.broken == set(), traced.messages
    assert traced.end("a")["t"] == 1.0
    later = [traced.end("a"), traced.find("event", event="a.end")]
    log = traced.start("log")
    rest = [r for r in traced.records if log["id"] in (r.get("id"), r.get("behavior"))]
    rest += [r for r in traced.records if r["kind"] == "log"]
    serial = traced.end("serial")
    for record in traced.records:
        if any(record is each for each in (*later, *rest, serial)):
            record["t"] = 2.0
    traced.records.sort(key=lambda record: record["t"])
    traced.number()
    assert "override" in traced.broken


async def test_an_overridden_behavior_may_end_too_early_for_the_overlap(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario main:
    do parallel(overlap: initial, start_to_start: -1s):
        wait elapsed(1s)
        a: parallel:
            b: wait elapsed(1s)
    with:
        override(a, b)
""")
    assert traced.end("a")["status"] == "cancelled"
    assert traced.find("run.end")["status"] == "failed"
    assert traced.broken == set(), traced.messages


@pytest.mark.parametrize(("overlap", "status"), [("", "passed"), ("(overlap: final)", "failed")])
async def test_a_behavior_overridden_before_its_start_counts_as_ended(
    trace_text: TraceText, overlap: str, status: str
) -> None:
    traced = await trace_text(f"""
scenario main:
    do a: parallel{overlap}:
        wait elapsed(1s)
        b: wait elapsed(2s)
    with:
        override(b, a, when_active)
""")
    assert traced.find("run.end")["status"] == status
    assert traced.broken == set(), traced.messages


@pytest.mark.parametrize(
    "modifiers", ["repeat(2)", "retry(2), inverter()", "inverter(), repeat(2), inverter(), inverter()"]
)
async def test_an_attempt_does_not_receive_the_end_of_the_last(trace_text: TraceText, modifiers: str) -> None:
    lines = "\n".join(f"            {modifier}" for modifier in modifiers.split(", "))
    traced = await trace_text(f"""
scenario main:
    event one
    do parallel:
        a: serial:
            wait elapsed(5s)
        with:
{lines}
            until @one if every(0.5s)
        serial:
            wait elapsed(1s)
            emit one
            wait elapsed(1s)
            emit one
""")
    assert traced.end("a")["t"] == 2.0
    assert traced.broken == set(), traced.messages


OVERRIDDEN = """
scenario worker:
    {own}
    do a: serial:
        b: wait elapsed(5s)
    with:
        override(a, b)
scenario main:
    do serial:
        c: worker({duration}) with:
            failure_is_success()
        log("x")
"""


@pytest.mark.parametrize(
    ("own", "duration", "end"),
    [
        ("inverter()", "", 0.0),
        ("running_is_failure()", "duration: 1s", 1.0),
        ("repeat(3)", "", 0.0),
        ("retry(3)", "", 0.0),
        ("success_is_failure()", "", 0.0),
        ("timeout(1s)", "duration: [2s..3s]", 2.0),
    ],
)
async def test_an_overridden_behavior_has_not_failed(
    trace_text: TraceText, own: str, duration: str, end: float
) -> None:
    traced = await trace_text(OVERRIDDEN.format(own=own, duration=duration))
    assert traced.end("a")["status"] == "cancelled"
    assert traced.find("run.end")["status"] == "passed"
    assert traced.start("log")["t"] == end
    assert traced.broken == set(), traced.messages
    if own == "inverter()":
        inverter = traced.start("inverter")
        traced.find("behavior.end", id=inverter["id"])["status"] = "succeeded"
        assert "modifier" in traced.broken


async def test_an_override_holds_while_its_behavior_runs_but_not_while_it_is_held(
    trace_text: TraceText,
) -> None:
    traced = await trace_text("""
scenario main:
    event go
    do parallel:
        b: serial:
            wait elapsed(1s)
        with:
            until elapsed(3s)
            override(c, a, when_active)
        a: serial:
            wait elapsed(5s)
        serial:
            wait elapsed(2s)
            c: wait elapsed(1s)
""")
    assert traced.start("c")["t"] == 2.0
    assert traced.broken == set(), traced.messages


async def test_an_overridden_behavior_does_not_start_while_the_other_is_active(trace_text: TraceText) -> None:
    text = """
scenario main:
    do parallel:
        a: wait elapsed(5s)
        serial:
            wait elapsed(1s)
            serial:
                wait elapsed(2s)
            with:
                override(b, a, {mode})
        serial:
            wait elapsed(2s)
            b: log("b")
"""
    skipped = await trace_text(text.format(mode="when_active"))
    assert skipped.broken == set(), skipped.messages
    traced = await trace_text(text.format(mode="on_start"))
    assert traced.broken == set(), traced.messages
    started = Traced(skipped.scenario, traced.records)
    assert started.broken == {"override"}


async def test_a_member_prevented_from_starting_need_not_overlap(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario main:
    event never
    do a: serial:
        parallel(overlap: any, end_to_end: [-1s..1s]):
            wait elapsed(1s)
            wait @never
            b: log("b")
    with:
        override(b, a, when_active)
""")
    assert not any(record["kind"] == "log" and record["message"] == "b" for record in traced.records)
    assert traced.broken == set(), traced.messages


async def test_an_overridden_member_has_ended_when_others_end(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario main:
    do serial:
        parallel(overlap: full):
            a: wait elapsed(5s)
            b: serial(duration: 3s):
                wait elapsed(9s)
            wait elapsed(1s)
        with:
            override(a, b)
            failure_is_success()
        log("x")
""")
    assert (traced.end("a")["t"], traced.start("log")["t"]) == (0.0, 3.0)
    assert traced.broken == set(), traced.messages


async def test_an_override_of_a_behavior_cancelled_at_its_start_does_not_hold(trace_text: TraceText) -> None:
    traced = await trace_text("""
scenario worker:
    do wait elapsed(2s)
scenario main:
    do a: serial:
        wait elapsed(1s)
        b: worker() with:
            until every(0.7s)
            override(a, b)
        wait elapsed(1s)
""")
    assert traced.end("a")["t"] == 2.0
    assert traced.broken == set(), traced.messages


# ---------------------------------------------------------------- clean-up

CLEANS_UP = """
action linger

scenario main:
    do serial:
        parallel:
            serial:
                linger() with:
                    until elapsed(2s)
            wait elapsed(3s)
        log("x")
"""


async def test_cancelled_actions_may_clean_up(trace_text: TraceText) -> None:
    @action("linger", open_ended=True)
    async def linger(ctx: ActionContext) -> None:
        try:
            await ctx.sleep(10.0)
        finally:
            await ctx.sleep(0.5)

    traced = await trace_text(CLEANS_UP, actions=[linger])
    assert traced.end("linger")["t"] == 2.5
    assert traced.broken == set(), traced.messages
    traced.drop(traced.find("behavior.cancel"))
    assert "until" in traced.broken
