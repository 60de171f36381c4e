"""`until`: a behavior ends exactly when an event occurs (7.6.2.5.4)."""

from __future__ import annotations

import pytest

from seoro.runtime.actions.context import ActionContext
from seoro.runtime.functions.actions import action
from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import RunText

IN = "\n" + 16 * " "  # between members of the behavior
ON = "\n" + 12 * " "  # between steps of a parallel member


def until(body: str, directives: str, beside: str = "wait elapsed(0s)") -> str:
    """Return a scenario with an `until` and a parallel sequence of changes."""
    separator = "\n            " if ":" in body else " "
    return f"""
scenario main:
    var n: int = 0
    event go
    event stop
    do parallel:
        serial:
            {body}{separator}with:
                {directives}
            log("after")
        serial:
            {beside}
"""


@pytest.mark.parametrize(
    ("body", "directives", "beside", "logs"),
    [
        (f"serial:{IN}wait elapsed(9s)", "until @go", f"wait elapsed(2s){ON}emit go", [(2, "after")]),
        ("log('early')", "until elapsed(3s)", "wait elapsed(0s)", [(0, "early"), (3, "after")]),
        (f"serial:{IN}emit go{IN}log('x')", "until @go", "wait elapsed(0s)", [(0, "after")]),
        (f"parallel:{IN}emit go{IN}log('y')", "until @go", "wait elapsed(0s)", [(0, "y"), (0, "after")]),
        (f"parallel:{IN}log('y'){IN}emit go", "until @go", "wait elapsed(0s)", [(0, "y"), (0, "after")]),
        (f"serial:{IN}wait @go{IN}log('sent')", "until @go", f"wait elapsed(1s){ON}emit go", [(1, "after")]),
        ("log('never')", "until n == 0", "wait elapsed(0s)", [(0, "after")]),
        ("log('x')", "until rise(n == 1)", f"wait elapsed(1s){ON}increment(n)", [(0, "x"), (1, "after")]),
        ("log('x')", "until every(2s, offset: 1s)", "wait elapsed(0s)", [(0, "x"), (1, "after")]),
        (
            "log('x')",
            "until @go if n == 1",
            f"emit go{ON}increment(n){ON}wait elapsed(1s){ON}emit go",
            [(0, "x"), (1, "after")],
        ),
    ],
)
async def test_a_behavior_ends_exactly_at_the_event(
    run_text: RunText, body: str, directives: str, beside: str, logs: list[tuple[float, str]]
) -> None:
    ran = await run_text(until(body, directives, beside))
    assert ran.verdict.passed, ran.verdict.reason
    assert ran.logs == logs


async def test_the_first_of_several_untils_ends_a_held_behavior(run_text: RunText) -> None:
    directives = "until elapsed(3s)\n                until @go\n                until elapsed(2s)"
    ran = await run_text(until("log('early')", directives))
    assert ran.logs == [(0.0, "early"), (2.0, "after")]


async def test_a_past_event_does_not_end_an_until(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event go
    do parallel:
        serial:
            emit go
            log("x") with:
                until @go
            log("next")
            wait @go
        serial:
            wait elapsed(1s)
            emit go
            wait elapsed(1s)
            emit go
""")
    assert ran.logs == [(0.0, "x"), (1.0, "next")]
    assert ran.verdict.duration == 2.0, "what ended it is past for what follows"


async def test_emissions_of_ended_members_are_past(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event go
    do parallel:
        serial:
            parallel:
                serial:
                    emit go
                    wait elapsed(9s)
                wait elapsed(9s)
            with:
                until @go
            wait @go
            log("next")
        serial:
            wait elapsed(1s)
            emit go
""")
    assert ran.logs == [(1.0, "next")]


async def test_a_failure_before_the_event_ends_an_until_at_once(run_text: RunText) -> None:
    text = "scenario broken:\n    do emit fail\n" + until("broken()", "until elapsed(3s)")
    verdict = (await run_text(text)).verdict
    assert verdict.status is RunStatus.FAILED
    assert verdict.duration == 0.0


async def test_behaviors_ended_by_until_clean_up_in_reverse_order_first(run_text: RunText) -> None:
    seen: list[tuple[str, float]] = []

    @action("work")
    async def work(context: ActionContext, name: str) -> None:
        try:
            await context.sleep(9.0)
        finally:
            seen.append((name, context.now))
            await context.sleep(1.0)

    text = "action work:\n    name: string\n" + until(
        "parallel:\n                work('a')\n                work('b')", "until elapsed(2s)"
    )
    ran = await run_text(text, actions=[work])
    assert seen == [("b", 2.0), ("a", 3.0)]
    assert ran.logs == [(4.0, "after")]


async def test_an_inner_until_does_not_affect_the_end_of_an_outer_one(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    event go
    do parallel:
        serial:
            serial:
                serial:
                    wait elapsed(9s)
                with:
                    until @go
                log("inner")
            with:
                until @go
            log("outer")
        serial:
            wait elapsed(1s)
            emit go
""")
    assert ran.logs == [(1.0, "outer")]


async def test_an_until_may_use_arguments_of_the_invocation(run_text: RunText) -> None:
    ran = await run_text("""
scenario nap:
    length: time
    do wait elapsed(9s)
scenario main:
    do serial:
        nap(length: 2s) with:
            until elapsed(it.length)
        log("after")
""")
    assert ran.logs == [(2.0, "after")]


async def test_an_endless_hold_is_reported(run_text: RunText) -> None:
    verdict = (await run_text(until("log('x')", "until @go"))).verdict
    assert verdict.status is RunStatus.FAILED
    assert "still waiting for: `until @go`" in verdict.reason


async def test_a_condition_without_a_value_is_an_error(run_text: RunText) -> None:
    verdict = (await run_text(until("log('x')", "until 6 / n == 0"))).verdict
    assert verdict.status is RunStatus.ERROR
    assert verdict.span is not None
    assert verdict.span.text == "6 / n"
