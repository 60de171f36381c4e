"""Deeply nested behaviors, and endless recursion of scenarios."""

from itertools import pairwise

import pytest

from seoro.runtime.execution.services import NESTING
from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import RunText

DEPTH = 500


def invocations(depth: int, operator: str) -> str:
    """Return scenarios that invoke each other; the last one logs."""
    names = [f"s{number}" for number in range(depth)]
    scenarios = [f"scenario {name}:\n    do {operator}:\n        {inner}()\n" for name, inner in pairwise(names)]
    last = f'scenario {names[-1]}:\n    do serial:\n        wait elapsed(1s)\n        log("inside")\n'
    return "\n".join([last, *reversed(scenarios), f"scenario main:\n    do {operator}:\n        {names[0]}()\n"])


@pytest.mark.parametrize("operator", ["serial", "parallel", "one_of"])
async def test_scenarios_may_be_invoked_five_hundred_deep(operator: str, run_text: RunText) -> None:
    ran = await run_text(invocations(DEPTH, operator))
    assert ran.verdict.status is RunStatus.PASSED
    assert ran.logs == [(1.0, "inside")]


@pytest.mark.parametrize("operator", ["serial", "parallel", "one_of"])
async def test_compositions_may_be_nested_five_hundred_deep(operator: str, run_text: RunText) -> None:
    lines = [f"{' ' * (level + 4)}{operator}:" for level in range(DEPTH - 1)]
    inner = f'{" " * (DEPTH + 3)}log("inside")'
    ran = await run_text("\n".join(["scenario main:", f"  do {operator}:", *lines, inner, ""]))
    assert ran.logs == [(0.0, "inside")]


async def test_deeply_nested_behaviors_are_cancelled_together(run_text: RunText) -> None:
    text = invocations(DEPTH, "serial").replace("scenario main:\n    do serial:", "scenario main:\n    do one_of:")
    ran = await run_text(text + "        wait elapsed(0.5s)\n")
    assert ran.verdict.status is RunStatus.PASSED
    assert ran.verdict.duration == 0.5
    assert sum(record.get("status") == "cancelled" for record in ran.records) == 2 * DEPTH + 1


async def test_a_behavior_may_have_a_hundred_modifiers(run_text: RunText) -> None:
    modifiers = "            inverter()\n" * 100
    ran = await run_text(f'scenario main:\n    do serial:\n        log("x")\n    with:\n{modifiers}')
    assert ran.verdict.status is RunStatus.PASSED


async def test_endless_recursion_of_a_scenario_is_an_error(run_text: RunText) -> None:
    ran = await run_text("scenario again:\n    do again()\nscenario main:\n    do again()\n")
    assert ran.verdict.status is RunStatus.ERROR
    assert f"behaviors are nested more than {NESTING} deep" in ran.verdict.reason
