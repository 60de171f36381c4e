"""Variables: initial values, changes, and the times of their effect (section 1 of the semantics)."""

from __future__ import annotations

import pytest

from seoro.errors import UsageError
from tests.runtime.conftest import RunText


async def test_a_variable_starts_with_its_default_and_is_changed_by_actions(run_text: RunText) -> None:
    text = """
scenario main:
    var n: int = 5
    var x: float
    do serial:
        increment(n)
        decrement(x)
        log(n == 6 and x == -1.0 ? "changed" : "no")
"""
    ran = await run_text(text)
    assert [message for _, message in ran.logs] == ["changed"]
    changes = [(record["path"], record["value"]) for record in ran.records if record["kind"] == "variable"]
    assert changes == [("n", 6), ("x", -1.0)]


async def test_the_parameters_of_a_struct_in_a_variable_are_chosen(run_text: RunText) -> None:
    text = """
struct mark:
    at: int
    BOUNDS
scenario main:
    var current: mark
    do log(current.at == 3 ? "three" : "no")
"""
    ran = await run_text(text.replace("BOUNDS", "keep(at in [3..3])"))
    assert [message for _, message in ran.logs] == ["three"]
    with pytest.raises(UsageError, match=r"`current\.at` has no value"):
        await run_text(text.replace("    BOUNDS\n", ""))


async def test_changes_take_effect_in_the_next_delta_cycle_and_add_up(run_text: RunText) -> None:
    text = """
scenario main:
    var n: int
    do serial:
        parallel:
            increment(n)
            log(n == 0 ? "as it was" : "no")
            increment(n)
        log(n == 2 ? "both" : "no")
"""
    assert [message for _, message in (await run_text(text)).logs] == ["as it was", "both"]


async def test_each_instance_has_its_own_variables(run_text: RunText) -> None:
    text = """
actor cart:
    var trips: int
scenario tell:
    var n: int = 0
    do serial:
        increment(n)
        log(n == 1 ? "fresh" : "used")
scenario main:
    a: cart
    b: cart
    do serial:
        tell()
        tell()
        increment(a.trips)
        log(a.trips == 1 and b.trips == 0 ? "own" : "shared")
"""
    assert [message for _, message in (await run_text(text)).logs] == ["fresh", "fresh", "own"]


async def test_whole_numbers_keep_their_bits(run_text: RunText) -> None:
    text = """
scenario main:
    var u: uint
    var i: int = 9223372036854775807
    do serial:
        decrement(u)
        increment(i)
        log(u == 18446744073709551615 and i < 0 ? "wrapped" : "no")
"""
    assert [message for _, message in (await run_text(text)).logs] == ["wrapped"]


@pytest.mark.parametrize(
    ("arguments", "outcome"),
    [
        ("2, '<', 3", "passed"),
        ("'a', '==', 'a'", "passed"),
        ("3m, '!=', 3m", "failed"),
        ("2, 'about', 3", "failed"),
        ("'a', '<', 3", "failed"),
    ],
)
async def test_compare_fails_if_it_is_not_true(arguments: str, outcome: str, run_text: RunText) -> None:
    verdict = (await run_text(f"scenario main:\n    do compare({arguments})\n")).verdict
    assert verdict.status.value == outcome
