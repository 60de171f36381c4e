"""Modifiers of `osc.helpers`, modifiers in Python, and compound modifiers."""

import asyncio
from itertools import pairwise

import pytest

from seoro import ActionFailed
from seoro.runtime.contracts.modifiers import Child, ModifierContext
from seoro.runtime.functions.modifiers import modifier
from seoro.runtime.verdict import Outcome, RunStatus
from tests.runtime.conftest import RunText

BROKEN = """
scenario broken:
    do serial:
        log("run")
        wait elapsed(1s)
        emit fail

scenario nap:
    length: time
    do wait elapsed(length)

"""


async def outcome(run_text: RunText, behavior: str, *modifiers: str) -> tuple[RunStatus, float, int]:
    """Return status, end and number of logs of a behavior within modifiers."""
    lines = "".join(f"        {text}\n" for text in modifiers)
    ran = await run_text(f"{BROKEN}scenario main:\n    do {behavior} with:\n{lines}")
    return ran.verdict.status, ran.verdict.duration, len(ran.logs)


@pytest.mark.parametrize(
    ("behavior", "modifiers", "expected"),
    [
        ('log("x")', ("repeat(3)",), (RunStatus.PASSED, 0.0, 3)),
        ("broken()", ("repeat(3)",), (RunStatus.FAILED, 1.0, 1)),
        ("broken()", ("retry(3)",), (RunStatus.FAILED, 3.0, 3)),
        ('log("x")', ("retry(3)",), (RunStatus.PASSED, 0.0, 1)),
        ("nap(2s)", ("timeout(2s)",), (RunStatus.PASSED, 2.0, 0)),
        ("nap(2s)", ("timeout(1.5s)",), (RunStatus.FAILED, 1.5, 0)),
        ("broken()", ("timeout(3.5s)", "inverter()", "repeat(2)"), (RunStatus.PASSED, 1.0, 1)),
        ("broken()", ("timeout(2.5s)", "repeat(9)", "inverter()"), (RunStatus.FAILED, 2.5, 3)),
        ("broken()", ("inverter()",), (RunStatus.PASSED, 1.0, 1)),
        ('log("x")', ("inverter()",), (RunStatus.FAILED, 0.0, 1)),
        ("broken()", ("failure_is_success()",), (RunStatus.PASSED, 1.0, 1)),
        ('log("x")', ("success_is_failure()",), (RunStatus.FAILED, 0.0, 1)),
        ("broken()", ("success_is_failure()",), (RunStatus.FAILED, 1.0, 1)),
        ("nap(1s)", ("running_is_failure()",), (RunStatus.FAILED, 0.0, 0)),
        ("nap(1s)", ("running_is_success()",), (RunStatus.PASSED, 0.0, 0)),
        ("nap(0s)", ("running_is_failure()",), (RunStatus.PASSED, 0.0, 0)),
        ("nap(1s)", ("timeout(4s)", "success_is_running()"), (RunStatus.FAILED, 4.0, 0)),
        ("broken()", ("timeout(4s)", "failure_is_running()"), (RunStatus.FAILED, 4.0, 1)),
        ("broken()", ("timeout(4s)", "success_is_running()"), (RunStatus.FAILED, 1.0, 1)),
    ],
)
async def test_modifiers_of_the_helpers_have_their_outcome(
    run_text: RunText, behavior: str, modifiers: tuple[str, ...], expected: tuple[RunStatus, float, int]
) -> None:
    assert await outcome(run_text, behavior, *modifiers) == expected


@pytest.mark.parametrize("modifier", ["repeat(0)", "repeat(-2)", "retry(0)", "timeout(limit)"])
async def test_invalid_arguments_fail_with_a_reason(run_text: RunText, modifier: str) -> None:
    text = f'scenario main:\n    limit: time = -1s\n    do log("never") with:\n        {modifier}\n'
    ran = await run_text(text)
    assert ran.verdict.status is RunStatus.FAILED
    assert "expected at least" in ran.verdict.reason
    assert ran.verdict.span is not None
    assert ran.verdict.span.text == modifier
    assert ran.logs == []


async def test_a_held_behavior_is_open_ended(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do serial(duration: 2s):
        log("done") with:
            success_is_running()
""")
    assert (ran.verdict.status, ran.verdict.duration) == (RunStatus.PASSED, 2.0)


async def test_each_repetition_draws_new_values(run_text: RunText) -> None:
    ran = await run_text("""
scenario shown:
    length: time with:
        keep(it in [1s..2s])
    do serial:
        wait elapsed(length)
        log("shown")

scenario main:
    do serial:
        shown() with:
            repeat(2)
        serial:
            wait elapsed([1s..2s])
            log("shown")
        with:
            repeat(2)
""")
    times = [0.0, *(time for time, _ in ran.logs)]
    lengths = {round(later - earlier, 6) for earlier, later in pairwise(times)}
    assert len(lengths) == 4


async def test_variables_are_reset_in_each_repetition(run_text: RunText) -> None:
    ran = await run_text("""
scenario count:
    var n: int = 0
    do serial:
        increment(n)
        log(n == 1 ? "once" : "more")

scenario main:
    do count() with:
        repeat(2)
""")
    assert ran.logs == [(0.0, "once"), (0.0, "once")]


async def test_the_modifiers_of_a_scenario_apply_to_each_of_its_invocations(run_text: RunText) -> None:
    ran = await run_text("""
scenario twice:
    text: string
    repeat(2)
    do log(text)

scenario main:
    repeat(2)
    do serial:
        twice("a")
        twice("b") with:
            repeat(2)
""")
    assert [text for _, text in ran.logs] == ["a", "a", "b", "b", "b", "b"] * 2


async def test_a_loop_without_time_is_an_error(run_text: RunText, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.runtime.execution.loops.STARTS", 1000)
    ran = await run_text('scenario main:\n    do serial:\n        log("x")\n    with:\n        repeat()\n')
    assert ran.verdict.status is RunStatus.ERROR
    assert "instantaneous loop" in ran.verdict.reason


async def test_the_trace_has_modifiers_as_behaviors(run_text: RunText) -> None:
    ran = await run_text('scenario main:\n    do log("x") with:\n        inverter()\n        repeat(2)\n')
    starts = {record["id"]: record for record in ran.records if record["kind"] == "behavior.start"}
    shown = [(record["type"], record["name"], starts[record["parent"]]["name"]) for record in starts.values()
             if record["type"] == "modifier"]  # fmt: skip
    assert shown == [("modifier", "inverter", "log"), ("modifier", "repeat", "inverter")]
    assert (ran.ends["repeat"], ran.ends["inverter"]) == ("succeeded", "failed")


# ---------------------------------------------------------------- compound modifiers

TELL = """
actor guide:
    level: int = 6

scenario guide.tell:
    n: int = 1
    do log(n == 3 ? "three" : n == 6 ? "six" : n == 1 ? "one" : "other")

modifier at of guide.tell:
    value: int
    keep(it.n == value)

modifier guide.at_level of guide.tell:
    keep(it.n == actor.level)

modifier at_half of guide.tell:
    double: int
    at(double / 2)

"""


@pytest.mark.parametrize(
    ("modifier", "expected"),
    [
        ("at(3)", "three"),
        ("at([3..3])", "three"),
        ("at_level()", "six"),
        ("other.at_level()", "three"),
        ("at_half(double: 6)", "three"),
        ("at(it.n)", "six"),
    ],
)
async def test_compound_modifiers_constrain_their_behavior(
    run_text: RunText, modifier: str, expected: str
) -> None:
    ran = await run_text(f"""{TELL}
scenario main:
    g: guide
    other: guide with:
        keep(it.level == 3)
    do g.tell() with:
        keep(it.n in [3, 6])
        keep(it.n == {"6" if "it.n" in modifier else "it.n"})
        {modifier}
""")
    assert [text for _, text in ran.logs] == [expected]


async def test_values_are_chosen_for_modifier_and_behavior_together(run_text: RunText) -> None:
    ran = await run_text(f"""{TELL}
scenario main:
    g: guide
    do g.tell() with:
        keep(it.n in [6..9])
        at([2..6])
""")
    assert [text for _, text in ran.logs] == ["six"]


async def test_unsatisfiable_constraints_are_an_error(run_text: RunText) -> None:
    ran = await run_text(f"""{TELL}
scenario main:
    g: guide
    do g.tell(n: 1) with:
        at(3)
""")
    assert ran.verdict.status is RunStatus.ERROR
    assert ran.logs == []


async def test_compound_modifiers_apply_others(run_text: RunText) -> None:
    ran = await run_text("""
modifier patient:
    limit: time
    timeout(limit)
    repeat(3)

scenario main:
    do serial:
        serial:
            log("tick")
            wait elapsed(1s)
        with:
            inverter()
            patient(1.5s)
        log("after")
""")
    assert ran.logs == [(0.0, "tick"), (1.0, "tick"), (1.5, "after")]


async def test_a_modifier_uses_an_actor_chosen_with_the_scenario(run_text: RunText) -> None:
    """The actor is chosen with all other values."""
    ran = await run_text("""
actor guide:
    level: int

modifier guide.level_of of tell:
    keep(it.n == actor.level)

scenario tell:
    n: int
    g: guide with:
        keep(it.level == 4)
    g.level_of()
    do log(n == 4 ? "four" : "other")

scenario main:
    do tell()
""")
    assert [text for _, text in ran.logs] == ["four"], ran.verdict


# ---------------------------------------------------------------- Python

DECLARED = """
modifier twice:
    pause: time = 1s
modifier patient
modifier stubborn
modifier lost
"""


@modifier("twice")
async def twice(ctx: ModifierContext, child: Child, pause: float) -> Outcome:
    await child.run()
    await ctx.sleep(pause)
    ctx.log(f"again at {ctx.now:g}")
    outcome = await child.run()
    assert outcome is not None
    return outcome


@modifier("patient")
async def patient(ctx: ModifierContext, child: Child) -> Outcome:
    raise ActionFailed("no patience")


@modifier("stubborn")
async def stubborn(ctx: ModifierContext, child: Child) -> Outcome:
    """Ignore the cancellation."""
    while True:
        try:
            outcome = await child.run()
            assert outcome is not None
            return outcome
        except asyncio.CancelledError:
            ctx.log("ignored")
            await child.run()


@modifier("lost")
async def lost(ctx: ModifierContext, child: Child) -> Outcome:
    await asyncio.sleep(1)
    raise AssertionError("it does not get here")


MODIFIERS = (twice, patient, stubborn, lost)


async def test_a_modifier_in_python_may_repeat_its_behavior(run_text: RunText) -> None:
    text = f'{DECLARED}scenario main:\n    do log("x") with:\n        twice(pause: 2s)\n'
    ran = await run_text(text, actions=MODIFIERS)
    assert ran.logs == [(0.0, "x"), (2.0, "again at 2"), (2.0, "x")]
    assert ran.verdict.passed


async def test_a_modifier_may_fail(run_text: RunText) -> None:
    text = f'{DECLARED}scenario main:\n    do log("x") with:\n        patient()\n'
    ran = await run_text(text, actions=MODIFIERS)
    assert (ran.verdict.status, ran.verdict.reason) == (RunStatus.FAILED, "`patient` failed: no patience")
    assert ran.logs == []


async def test_a_modifier_that_ignores_its_cancellation_is_ended(run_text: RunText) -> None:
    text = f"{DECLARED}{BROKEN}scenario main:\n    do nap(5s) with:\n        timeout(1s)\n        stubborn()\n"
    ran = await run_text(text, actions=MODIFIERS)
    assert (ran.verdict.status, ran.verdict.duration) == (RunStatus.FAILED, 1.0)
    assert ran.logs == [(1.0, "ignored")]


async def test_a_modifier_waits_for_its_context_and_child_only(run_text: RunText) -> None:
    text = f'{DECLARED}scenario main:\n    do log("x") with:\n        lost()\n'
    ran = await run_text(text, actions=MODIFIERS)
    assert ran.verdict.status is RunStatus.ERROR
    assert "its context and its child only" in ran.verdict.reason
