"""Behaviors nest to any depth that a text has; a scenario that invokes itself without end is found."""

from itertools import pairwise

import pytest

from seoro.runtime.services import NESTING
from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import RunText

DEPTH = 500


def invocations(depth: int, operator: str) -> str:
    """Scenarios that invoke each other, the last of which logs."""
    names = [f"s{number}" for number in range(depth)]
    scenarios = [f"scenario {name}:\n    do {operator}:\n        {inner}()\n" for name, inner in pairwise(names)]
    last = f'scenario {names[-1]}:\n    do serial:\n        wait elapsed(1s)\n        log("inside")\n'
    return "\n".join([last, *reversed(scenarios), f"scenario main:\n    do {operator}:\n        {names[0]}()\n"])


@pytest.mark.parametrize("operator", ["serial", "parallel", "one_of"])
async def test_scenarios_invoke_each_other_five_hundred_deep(operator: str, run_text: RunText) -> None:
    ran = await run_text(invocations(DEPTH, operator))
    assert ran.verdict.status is RunStatus.PASSED
    assert ran.logs == [(1.0, "inside")]


@pytest.mark.parametrize("operator", ["serial", "parallel", "one_of"])
async def test_compositions_stand_five_hundred_deep_in_each_other(operator: str, run_text: RunText) -> None:
    lines = [f"{' ' * (level + 4)}{operator}:" for level in range(DEPTH - 1)]
    inner = f'{" " * (DEPTH + 3)}log("inside")'
    ran = await run_text("\n".join(["scenario main:", f"  do {operator}:", *lines, inner, ""]))
    assert ran.logs == [(0.0, "inside")]


async def test_what_is_nested_deeply_is_ended_as_a_whole(run_text: RunText) -> None:
    text = invocations(DEPTH, "serial").replace("scenario main:\n    do serial:", "scenario main:\n    do one_of:")
    ran = await run_text(text + "        wait elapsed(0.5s)\n")
    assert ran.verdict.status is RunStatus.PASSED
    assert ran.verdict.duration == 0.5
    assert sum(record.get("status") == "cancelled" for record in ran.records) == 2 * DEPTH + 1


async def test_a_hundred_modifiers_of_one_behavior(run_text: RunText) -> None:
    modifiers = "            inverter()\n" * 100
    ran = await run_text(f'scenario main:\n    do serial:\n        log("x")\n    with:\n{modifiers}')
    assert ran.verdict.status is RunStatus.PASSED


async def test_a_scenario_that_invokes_itself_without_end_is_an_error(run_text: RunText) -> None:
    ran = await run_text("scenario again:\n    do again()\nscenario main:\n    do again()\n")
    assert ran.verdict.status is RunStatus.ERROR
    assert f"more than {NESTING} behaviors are nested" in ran.verdict.reason
