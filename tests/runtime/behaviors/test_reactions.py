"""`on`: reactions of a scenario or an action to events (7.6.2.5.5)."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.runtime.actions.context import ActionContext
from seoro.runtime.functions.actions import action
from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import Ran, RunText


def events(ran: Ran, name: str) -> list[float]:
    """Return the times of an event of the entry scenario."""
    return [r["t"] for r in ran.records if r["kind"] == "event" and r["name"] == f"main.{name}"]


@pytest.mark.parametrize(
    ("specification", "when"),
    [
        ("@go", [0.0, 1.0, 2.0]),
        ("@go if n == 2", [2.0]),
        ("@go as g if g.n > 0", [1.0, 2.0]),
        ("n >= 1", [1.0]),
        ("n != 1", [0.0, 2.0]),
        ("rise(n == 1)", [1.0]),
        ("fall(n == 1)", [2.0]),
        ("elapsed(1.5s)", [1.5]),
        ("every(1s)", [0.0, 1.0, 2.0, 3.0]),
        ("every(2s, offset: 0.5s)", [0.5, 2.5]),
        ("@twice", [0.0, 1.0, 2.0]),
        ("@derived", [1.0]),
    ],
)
async def test_on_reacts_to_every_occurrence_in_its_instant(
    run_text: RunText, specification: str, when: list[float]
) -> None:
    ran = await run_text(f"""
scenario main:
    event go(n: int)
    event twice is @go
    event derived is rise(n == 1)
    event answer
    var n: int = 0
    on {specification}:
        emit answer
    do serial:
        emit go(0)
        wait elapsed(1s)
        increment(n)
        emit go(1)
        wait elapsed(1s)
        increment(n)
        emit go(2)
        wait elapsed(1s)
""")
    assert ran.verdict.passed
    assert events(ran, "answer") == when


async def test_members_of_on_run_in_order_with_the_occurrence(run_text: RunText, tmp_path: Path) -> None:
    (tmp_path / "notes.py").write_text("noted = []\n\ndef note(n: int) -> None: noted.append(n)\n\n"
                                       "def notes() -> str: return str(noted)\n")  # fmt: skip
    ran = await run_text("""
scenario main:
    event go(n: int)
    event twice(n: int)
    def note(n: int) is external notes.note()
    def notes() -> string is external notes.notes()
    on @go as g if g.n > 0:
        call note(g.n)
        emit twice(g.n * 2)
        call note(g.n * 2)
    on @twice as t if true:
        call note(t.n)
    do serial:
        emit go(0)
        emit go(3)
        wait @twice
        wait elapsed(0s)
        log(notes())
""")
    assert ran.logs == [(0.0, "[3, 6, 6]")]
    kinds = [record["type"] for record in ran.records if record["kind"] == "behavior.start"]
    assert kinds.count("call") == 3
    assert "main/on[1]/emit[1]" in [record.get("path") for record in ran.records]


async def test_on_ignores_its_own_emissions_and_endless_reactions_are_an_error(
    run_text: RunText, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.runtime.execution.loops.STARTS", 1000)
    text = "scenario main:\n    event a(n: int)\n    event b(n: int)\n"
    text += "    on @a as x if true:\n        emit {}(x.n + 1)\n{}    do serial:\n        emit a(0)\n"
    text += "        wait elapsed(1s)\n"
    once = await run_text(text.format("a", ""))
    assert once.verdict.passed
    assert events(once, "a") == [0.0, 0.0]
    verdict = (await run_text(text.format("b", "    on @b as x if true:\n        emit a(x.n)\n"))).verdict
    assert verdict.status is RunStatus.ERROR
    assert "instantaneous loop" in verdict.reason


async def test_on_reacts_until_its_scenario_ends(run_text: RunText) -> None:
    ran = await run_text("""
scenario inner:
    event late
    on every(1s):
        emit late
    do wait elapsed(1.5s)
scenario main:
    event answer
    do serial:
        inner()
        wait elapsed(5s)
""")
    assert [r["t"] for r in ran.records if r["kind"] == "event" and r["name"].endswith("late")] == [0.0, 1.0]


@pytest.mark.parametrize(
    ("ending", "around", "answers"),
    [
        ("emit end", "elapsed(1s)", 1),
        ("wait elapsed(0s)", "elapsed(1s)", 1),
        ("wait elapsed(9s)", "elapsed(1s)", 1),
        ("wait elapsed(9s)", "elapsed(9s)", 0),
    ],
)
async def test_on_reacts_last_to_the_end_of_its_scenario(
    run_text: RunText, ending: str, around: str, answers: int
) -> None:
    """It also reacts when `until` ends its invocation, but not after other cancellations."""
    ran = await run_text(f"""
scenario inner:
    event over
    on @end:
        emit over
    do {ending}
scenario main:
    do serial:
        one_of:
            inner() with:
                until {around}
            wait elapsed(2s)
        wait elapsed(1s)
""")
    assert len([r for r in ran.records if r["kind"] == "event" and r["name"].endswith("over")]) == answers


async def test_a_scenario_cancelled_in_the_cycle_of_the_event_does_not_react(run_text: RunText) -> None:
    ran = await run_text("""
scenario inner:
    event go
    event answer
    on @go:
        emit answer
    do serial:
        emit go
        wait elapsed(9s)
scenario main:
    do serial:
        one: inner() with:
            until @one.go
        wait elapsed(1s)
""")
    assert ran.verdict.passed
    assert ran.verdict.duration == 1.0
    assert not [r for r in ran.records if r["kind"] == "event" and r["name"].endswith("answer")]


async def test_reactions_of_an_action_may_end_it(run_text: RunText) -> None:
    seen = []

    @action("work")
    async def work(context: ActionContext, limit: float) -> None:
        try:
            await context.sleep(9.0)
        finally:
            seen.append(context.now)

    ran = await run_text(
        """
action work:
    limit: time
    event done
    on elapsed(limit):
        emit done
        emit end
scenario main:
    do parallel:
        w: work(limit: 2s)
        serial:
            wait @w.done
            log("done")
        serial:
            wait @w.end
            log("ended")
""",
        actions=[work],
    )
    assert ran.verdict.passed
    assert seen == [2.0]
    assert ran.logs == [(2.0, "done"), (2.0, "ended")]


async def test_an_argument_without_a_value_is_an_error_with_its_position(run_text: RunText) -> None:
    verdict = (
        await run_text("""
scenario main:
    var n: int = 0
    event go(n: int)
    on elapsed(1s):
        emit go(6 / n)
    do wait elapsed(2s)
""")
    ).verdict
    assert verdict.status is RunStatus.ERROR
    assert verdict.duration == 1.0
    assert verdict.span is not None
    assert verdict.span.text == "6 / n"
