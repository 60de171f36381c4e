"""Invocation of scenarios."""

import pytest

from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import RunText


async def test_emit_end_ends_the_innermost_scenario(run_text: RunText) -> None:
    ran = await run_text("""
scenario inner:
    do parallel:
        serial:
            late: wait elapsed(2s)
            log("never")
        serial:
            wait elapsed(1s)
            emit end
            log("never either")

scenario main:
    do serial:
        inner()
        log("outer")
        wait elapsed(2s)
""")
    assert ran.logs == [(1.0, "outer")]
    assert ran.ends["late"] == "cancelled"
    assert ran.verdict.passed
    assert ran.verdict.duration == 3.0


async def test_emit_fail_fails_the_scenario_and_outer_behaviors(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do parallel:
        wait elapsed(5s)
        serial:
            wait elapsed(1s)
            emit fail
""")
    assert ran.verdict.status is RunStatus.FAILED
    assert ran.verdict.duration == 1.0


async def test_arguments_are_evaluated_in_the_invoking_scenario(run_text: RunText) -> None:
    ran = await run_text("""
scenario say:
    what: string
    times: int = 2
    do log(what + " twice")

scenario main:
    name: string = "hello"
    do say(name + "!")
""")
    assert ran.logs == [(0.0, "hello! twice")]


async def test_scenarios_of_actors_know_their_actor(run_text: RunText) -> None:
    ran = await run_text("""
actor cat:
    sound: string = "meow"

scenario cat.speak:
    do log(actor.sound)

scenario main:
    tom: cat
    do tom.speak()
""")
    assert ran.logs == [(0.0, "meow")]


async def test_integer_division_by_zero_is_an_error_with_its_position(run_text: RunText) -> None:
    ran = await run_text("""
scenario say:
    number: int
    do log("x")

scenario main:
    zero: int = 0
    do serial:
        log("before")
        say(1 / zero)
""")
    assert ran.verdict.status is RunStatus.ERROR
    assert ran.verdict.span is not None
    assert ran.verdict.span.text == "1 / zero"
    assert ran.logs == [(0.0, "before")]


async def test_endless_recursion_of_a_scenario_is_an_error(run_text: RunText) -> None:
    ran = await run_text("scenario main:\n    do main()\n")
    assert ran.verdict.status is RunStatus.ERROR
    assert "behaviors are nested more than" in ran.verdict.reason


async def test_too_many_steps_in_an_instant_are_an_error(
    run_text: RunText, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.runtime.execution.loops.STARTS", 50)
    members = "        emit go\n" * 60
    ran = await run_text(f"scenario main:\n    event go\n    do serial:\n{members}")
    assert ran.verdict.status is RunStatus.ERROR
    assert "instantaneous loop" in ran.verdict.reason
