"""Explanation of a verdict besides its reason: awaited events and conditions with their values, and emitters."""

import json

from seoro.errors import ActionFailed
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.explain.reasons import reason_text
from seoro.runtime.explanation import Activity, Explanation, Kind
from seoro.runtime.functions.actions import action
from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import Ran, RunText


def explanation(ran: Ran) -> Explanation:
    assert ran.verdict.explanation is not None
    plain = ran.verdict.explanation.plain()
    assert json.loads(json.dumps(plain)) == ran.records[-1]["explanation"]
    return ran.verdict.explanation


def the_activity(ran: Ran) -> Activity:
    [activity] = explanation(ran).activities
    return activity


async def test_a_passed_run_has_no_explanation(run_text: RunText) -> None:
    ran = await run_text("scenario main:\n    do wait elapsed(1s)\n")
    assert ran.verdict.explanation is None
    assert ran.records[-1]["explanation"] is None
    assert reason_text(ran.verdict) == ""


async def test_the_explanation_of_a_timeout_has_the_event_and_its_emitters(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event go
    do parallel:
        serial:
            wait elapsed(2s)
            wait @go
        serial:
            slow: serial:
                wait elapsed(1h)
            emit go
    with:
        timeout(5s)
""")
    found = explanation(ran)
    assert (found.time, found.path) == (5.0, "main/parallel[0]")
    waits, slow = found.activities
    assert (waits.kind, waits.ongoing.text, waits.ongoing.since, waits.event) == (
        Kind.WAITS,
        "wait @go",
        2.0,
        "go",
    )
    [emitter] = waits.emitters
    assert (emitter.text, emitter.time) == ("emit go", None)
    assert emitter.after is not None
    assert (emitter.after.text, emitter.after.since) == ("wait elapsed(1h)", 0.0)
    assert (slow.ongoing.text, slow.due) == ("wait elapsed(1h)", 3600.0)


async def test_conditions_are_explained_with_the_values_of_the_end(run_text: RunText) -> None:
    ran = await run_text("""
struct limits:
    top: speed = 3mps

scenario main:
    var count: int = 0
    top: speed = 2mps
    limit: limits
    do parallel:
        wait count + 1 >= 3 and top < limit.top and count in [2, 3]
        increment(count)
    with:
        timeout(5s)
""")
    assert [(r.text, r.value, r.unit) for r in the_activity(ran).readings] == [
        ("count + 1", 2, ""),
        ("count", 1, ""),
        ("top", 2.0, "m/s"),
        ("limit.top", 3.0, "m/s"),
    ]


async def test_explained_values_are_those_of_the_end(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    var count: int = 0
    do serial:
        serial:
            wait count > 0
        with:
            failure_is_success()
            timeout(1s)
        increment(count)
        serial:
            wait count > 1
        with:
            timeout(1s)
""")
    assert [r.value for r in the_activity(ran).readings] == [1]


async def test_a_label_without_an_instance_is_reported(run_text: RunText) -> None:
    ran = await run_text("""
scenario part:
    size: int = 1
    do wait elapsed(1s)

scenario main:
    do parallel(duration: 1s):
        wait first.size == 1
        serial:
            wait elapsed(1h)
            first: part()
""")
    [reading] = explanation(ran).activities[0].readings
    assert "the label `first` has not been invoked yet" in reading.error
    assert "has no value" in reason_text(ran.verdict)


async def test_an_event_before_its_wait_is_reported(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event go
    do serial:
        emit go
        wait elapsed(1s)
        wait @go
""")
    assert ran.verdict.reason.startswith("nothing can happen any more")
    [emitter] = the_activity(ran).emitters
    assert emitter.time == 0.0
    assert "was reached at 0.000 s, before this wait" in reason_text(ran.verdict)


async def test_an_event_without_emitter_is_reported(run_text: RunText) -> None:
    ran = await run_text("scenario main:\n    event go\n    do wait @go\n")
    assert the_activity(ran).emitters == ()
    assert "no `emit` of `go` in the scenario" in reason_text(ran.verdict)


async def test_emitters_in_invoked_and_derived_scenarios_and_reactions_are_found(run_text: RunText) -> None:
    ran = await run_text("""
scenario base:
    event done

scenario special inherits base:
    on @done:
        emit done
    do serial:
        wait elapsed(1h)
        emit done

scenario main:
    do parallel(duration: 1s):
        leg: special()
        wait @leg.done
        wait @leg.end
""")
    waits = {activity.event: activity.emitters for activity in explanation(ran).activities if activity.event}
    assert [emitter.text for emitter in waits["leg.done"]] == ["emit done", "emit done"]
    [end] = waits["leg.end"]
    assert end.text == "the end of `leg`"
    assert end.after is not None


async def test_a_derived_event_has_the_values_of_its_condition(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    var count: int = 0
    event many is count > 3
    do serial(duration: 1s):
        wait @many
""")
    assert [r.text for r in the_activity(ran).readings] == ["count"]


async def test_the_explanation_of_emit_fail_shows_other_activities(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do parallel:
        wait elapsed(1h)
        serial:
            wait elapsed(3s)
            emit fail
""")
    assert ran.verdict.reason == "`emit fail`"
    assert the_activity(ran).ongoing.text == "wait elapsed(1h)"


async def test_a_held_until_is_reported(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event go
    do serial:
        serial:
            log("done")
        with:
            until @go
    with:
        timeout(1s)
""")
    activity = the_activity(ran)
    assert (activity.kind, activity.ongoing.text, activity.event) == (Kind.HOLDS, "until @go", "go")


async def test_an_action_that_failed_shows_its_arguments(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    var count: int = 0
    do serial:
        increment(count)
        compare(count + 1, '==', 3)
""")
    found = explanation(ran)
    assert found.path == "main/serial[0]/compare[1]"
    assert [(r.text, r.value) for r in found.readings] == [("left_value: count + 1", 2)]


async def test_a_running_action_is_reported_with_its_start(run_text: RunText) -> None:
    @action("dawdle")
    async def dawdle(ctx: ActionContext) -> None:
        await ctx.sleep(100.0)

    text = """
action dawdle

scenario main:
    do serial(duration: 2s):
        wait elapsed(1s)
        dawdle()
"""
    ran = await run_text(text, actions=[dawdle])
    activity = the_activity(ran)
    assert (activity.kind, activity.ongoing.text, activity.ongoing.since) == (Kind.RUNS, "dawdle", 1.0)


async def test_a_failed_member_is_explained_by_its_own_reason(run_text: RunText) -> None:
    @action("refuse")
    async def refuse(ctx: ActionContext, what: str) -> None:
        raise ActionFailed("no")

    text = """
action refuse:
    what: string

scenario main:
    thing: string = "ab"
    do parallel:
        wait elapsed(1h)
        refuse(thing)
"""
    ran = await run_text(text, actions=[refuse])
    assert [(r.text, r.value) for r in explanation(ran).readings] == [("what: thing", "ab")]


async def test_the_explanation_of_an_error_shows_other_activities(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    var count: int = 0
    do parallel:
        wait elapsed(1h)
        serial:
            wait elapsed(1s)
            log(1 / count)
""")
    assert ran.verdict.status is RunStatus.ERROR
    assert "wait elapsed(1h)" in [activity.ongoing.text for activity in explanation(ran).activities]


async def test_many_activities_are_counted(run_text: RunText) -> None:
    members = "".join("        wait elapsed(1h)\n" for _ in range(20))
    ran = await run_text(f"scenario main:\n    do parallel(duration: 1s):\n{members}")
    found = explanation(ran)
    assert len(found.activities) + found.more == 20
    assert f"and {found.more} more activities" in reason_text(ran.verdict)


async def test_the_text_shows_the_lines_and_fits_the_terminal(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event go
    do serial:
        wait elapsed(2s)
        wait @go
    with:
        timeout(5s)
""")
    text = reason_text(ran.verdict)
    assert text.startswith("failed: timeout: still running after 5 s\n")
    assert "9 |         wait @go\n   |         -------- waiting since 2.000 s\n" in text.replace(
        "   |         -", "   |         -"
    )
    assert "\x1b" not in text
    narrow = reason_text(ran.verdict, width=60)
    notes = narrow[narrow.index(" = at") :].splitlines()
    assert all(len(line) <= 60 or " " not in line.strip() for line in notes if "/" not in line)
    assert len(notes) > len(text[text.index(" = at") :].splitlines())
    assert "\x1b[31;1mfailed\x1b[0m: timeout" in reason_text(ran.verdict, colour=True)


async def test_the_last_failure_of_one_of_is_explained(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    var count: int = 0
    do one_of:
        compare(count, '==', 1)
        compare(count, '==', 2)
""")
    assert [(r.text, r.value) for r in explanation(ran).readings] == [("left_value: count", 0)]
