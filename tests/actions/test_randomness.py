"""The methods of the struct `random` in `osc.helpers`."""

from typing import Any

import pytest

from seoro import UsageError
from seoro.actions import randomness
from seoro.runtime.values.environment import MethodContext
from tests.runtime.conftest import Prepare, RunText

SCENARIO = """
scenario main:
    r: random
    x: float = r.get_float(2.0, 3.0)
    do serial:
        log(x)
        log(r.get_int(1, 1000))
        log(r.get_random_string(["a", "b", "c"]))
        wait elapsed(1s)
        log(r.get_int(1, 1000))
"""


async def test_random_values_come_from_the_seed(run_text: RunText) -> None:
    first, again, other = [(await run_text(SCENARIO, seed)).logs for seed in (7, 7, 8)]
    assert first == again != other
    assert 2.0 <= float(first[0][1]) <= 3.0
    assert first[1][1] != first[3][1]


async def test_a_value_drawn_for_a_parameter_does_not_change_with_others(prepare_text: Prepare) -> None:
    text = """
scenario main:
    r: random
    x: float = r.get_float(0.0, 1.0)
    y: float
    z: float = x
    dice: list of die
    keep(dice.size() == 20)
    first: int = roll()
    second: int = roll()
    third: int = roll()
    keep(y in [0.0..x])
    def roll() -> int is expression r.get_int(1, 1000)

struct die:
    random: random
    value: int = random.get_int(1, 1000)
"""
    async with prepare_text(text) as run:
        found: dict[str, Any] = dict(run.parameters)
    assert len({die["value"] for die in found["dice"]}) > 10
    assert len({found["first"], found["second"], found["third"]}) > 1
    assert found["x"] == found["z"]
    assert 0.0 <= found["y"] <= found["x"] <= 1.0


async def test_fields_of_two_scenarios_draw_from_one_stream(run_text: RunText) -> None:
    text = "scenario main:\n    a: random\n    b: random\n    do serial:\n        log({})\n        log({})\n"
    calls = "a.get_int(1, 1000)", "b.get_int(1, 1000)", "a.get_int(1, 1000)"
    one = await run_text(text.format(calls[0], calls[1]))
    two = await run_text(text.format(calls[0], calls[2]))
    assert one.logs == two.logs


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ("get_int(3, 2)", r"`min_val` \(3\) is above `max_val` \(2\)"),
        ("get_float(1.5, 1.0)", r"`min_val` \(1.5\) is above `max_val` \(1\)"),
        ("get_random_string(['a'].filter(it == 'b'))", "`elements_list` is empty"),
    ],
)
async def test_draws_from_empty_sets_are_reported(call: str, message: str, prepare_text: Prepare) -> None:
    kind = {"get_int": "int", "get_float": "float"}.get(call.partition("(")[0], "string")
    with pytest.raises(UsageError, match=message):
        async with prepare_text(f"scenario main:\n    r: random\n    x: {kind} = r.{call}\n"):
            pass


def test_a_seed_of_the_scenario_is_independent_of_that_of_the_run() -> None:
    from pathlib import Path

    drawn = []
    for seed in (1, 2):
        run = MethodContext(seed, Path("x.osc"))
        randomness.seed(run, 5)
        drawn.append([randomness.get_int(run, 1, 1000) for _ in range(4)])
    assert drawn[0] == drawn[1]


async def test_draws_of_coverage_do_not_change_other_values(run_text: RunText) -> None:
    text = "scenario main:\n    r: random\n{}    do serial:\n        log(r.get_int(1, 1000))\n"
    cover = "    cover(drawn, expression: r.get_int(1, 1000), event: start)\n"
    assert (await run_text(text.format(cover))).logs == (await run_text(text.format(""))).logs
