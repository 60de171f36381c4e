"""Conversions between integer types, which wrap (7.4.2.3.1, 7.4.2.4.1)."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.runtime.values.values import Range, Value
from tests.runtime.choose.test_choose import chosen, in_main
from tests.runtime.conftest import RunText
from tests.runtime.expressions.test_evaluate import fields, value

UINT_MAX = 2**64 - 1
GIVEN = """
    u: uint = 2
    i: int = 7
    us: list of uint = [u - 3, 5]
    ur: range of uint = [u .. u - 3]
"""


def about(folder: Path, type_: str, expression: str, declarations: str = "") -> Value:
    """Return the value of an expression about a `uint` 2 and an `int` 7."""
    return fields(folder, f"{declarations}\nscenario main:{GIVEN}    x: {type_} = {expression}\n")["x"]


@pytest.mark.parametrize(
    ("type_", "expression", "expected"),
    [
        ("int", "u - 3", -1),
        ("uint", "i - 9", UINT_MAX - 1),
        ("list of int", "[u - 3]", (-1,)),
        ("list of int", "us", (-1, 5)),
        ("list of int", "[i, us]", (7, -1, 5)),
        ("list of int", "us.filter(it > 5)", (-1,)),
        ("range of int", "[u - 3 .. 5]", Range(-1, 5)),
        ("range of int", "u - 3", Range(-1, -1)),
        ("range of int", "ur", Range(-1, 2)),
        ("int", "(true ? u - 3 : i)", -1),
        ("int", "(u - 3) / i", 0),
        ("int", "(u - 9) % i", 0),
        ("float", "i - u + 0.5", 5.5),
    ],
)
def test_integers_wrap_when_assigned(type_: str, expression: str, expected: Value, tmp_path: Path) -> None:
    assert about(tmp_path, type_, expression) == expected


@pytest.mark.parametrize(
    "expression",
    [
        "u - 3 == -1",
        "-1 == u - 3",
        "u - 3 != 1 and u - 3 < i and i > u - 3 and -1 >= u - 3",
        "2 - 3 == -1 and 2 - 3 > -2",
        "2 - 3 in [-5 .. 5] and 2 - 3 in [-1, 7]",
        "i - 8 in us and i - 8 in ur and [i - 8 .. 1] in ur",
        "us == [-1, 5] and us != [1, 5] and [-1, 5] == us",
        "ur == [-1 .. 2] and not (i in ur)",
        "i == 7.0 and i in [6.5 .. 7.5] and i in [0.5, 7.0]",
    ],
)
def test_integers_are_compared_as_one_type(expression: str, tmp_path: Path) -> None:
    assert about(tmp_path, "bool", expression) is True


def test_an_index_out_of_range_stays_an_error(tmp_path: Path) -> None:
    with pytest.raises(Exception, match="negative"):
        value(tmp_path, "uint", "-1")


@pytest.mark.parametrize(
    ("type_", "constraint", "expected"),
    [
        ("int", "it == u - 3", -1),
        ("uint", "it == i - 8", UINT_MAX),
        ("uint", "it in [-1 .. -1]", UINT_MAX),
        ("int", "it - i == u - 10", -1),
        ("uint", "it < i - 6", 0),
        ("uint", "it in [i - 8, i - 9] and it == i - 8", UINT_MAX),
    ],
)
def test_constraints_on_integers_of_both_types_are_solved(
    type_: str, constraint: str, expected: Value, tmp_path: Path
) -> None:
    given = ("u: uint = 2", "i: int = 7")
    assert in_main(tmp_path, *given, f"x: {type_} with:\n    keep({constraint})")["x"] == expected


def test_bounds_of_another_integer_type_override_defaults(tmp_path: Path) -> None:
    assert in_main(tmp_path, "i: int = 3", "x: uint = 9", "keep(x in [i .. 3])")["x"] == 3


def test_overrides_are_converted(tmp_path: Path) -> None:
    text = "scenario main:\n    u: uint = 2\n    x: int\n"
    assert chosen(tmp_path, text, {"x": "u - 3"})["x"] == -1


async def test_integers_wrap_as_arguments_of_behaviors(run_text: RunText) -> None:
    run = await run_text("""
import osc.helpers
scenario inner:
    n: int
    do log(n)
scenario main:
    event e(n: int)
    event f is @e as o if o.n == u - 3
    u: uint = 2
    var v: int = u - 3
    var s: int = sample(u - 4, @e, u - 5)
    def same(n: int) -> int is expression n
    def less(n: uint) -> int is expression n - 3
    do serial:
        log(v)
        log(s)
        log(same(u - 3))
        log(less(2))
        inner(u - 3)
        inner() with:
            keep(it.n == u - 3)
        parallel:
            serial:
                wait @f
                log("occurred")
            serial:
                wait elapsed(1s)
                emit e(u - 3)
        wait elapsed(1s)
        log(s)
""")
    assert [text for _, text in run.logs] == ["-1", "-3", "-1", "-1", "-1", "-1", "occurred", "-2"]
