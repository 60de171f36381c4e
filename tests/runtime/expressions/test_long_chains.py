"""Long chains of operators, as in generated files, without recursion."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.runtime.choose.test_choose import in_main
from tests.runtime.conftest import RunText
from tests.runtime.expressions.test_evaluate import fields

MANY = 400


def row(operator: str, operand: str, count: int = MANY) -> str:
    """Return a chain of operands; `#` is the number of each."""
    return f" {operator} ".join(operand.replace("#", str(number)) for number in range(count))


def table(row_: str, last: str, count: int = MANY) -> str:
    """Return a chain of `? :`; `#` is the number of each."""
    return "".join(row_.replace("#", str(number)) for number in range(count)) + last


@pytest.mark.parametrize(
    "members",
    [
        ("x: int with:\n    keep(it in [1..9])", f"keep({row('+', 'x')} == {4 * MANY})"),
        (
            "x: uint with:\n    keep(it in [1..9])",
            "i: int = 0",
            f"keep({row('+', 'x')} - 1 + i == {4 * MANY - 1})",
        ),
        ("x: float with:\n    keep(it in [1..9])", f"keep({row('+', 'x')} == {4 * MANY}.0)"),
        ("x: float with:\n    keep(it in [1..9])", f"keep({row('+', '2 * x')} <= {9 * MANY}.0)", "keep(x == 4.0)"),
        ("x: int with:\n    keep(it in [3..4])", f"keep({row('*', 'x')} == 0)"),  # wraps
        ("x: int with:\n    keep(it in [1..9])", f"keep({row('and', 'x != # + 5')})", "keep(x > 3)"),
        ("x: int with:\n    keep(it in [1..900])", f"keep({row('or', 'x == # + 4')})", "keep(x < 5)"),
        ("x: int with:\n    keep(it in [1..900])", f"keep({row('and', 'x in [4..# + 4]')})"),
        ("x: int with:\n    keep(it in [3..4])", f"keep({row('=>', 'x > 3', MANY + 1)})"),
        ("x: int with:\n    keep(it in [3..4])", f"keep({row('==', '(x > 3)', MANY + 1)} == true)"),
        ("x: int with:\n    keep(it in [0..900])", f"keep(({table('x == # ? # + 7 : ', '0')}) == 11)"),
        (
            "x: int with:\n    keep(it in [3..4])",
            "s: string with:\n    keep(it in ['a'])",
            f"keep({row('+', 's')} == 'a' or x == 4)",
        ),
        (
            "x: int with:\n    keep(it in [4..4])",
            f"a: list of int with:\n    keep(it.size() == {MANY})",
            *(f"keep(a[{number}] in [0..1])" for number in range(MANY)),
            "keep(a.count(it > 0) == 3)",
        ),
    ],
    ids=lambda members: members[-1][:12],
)
def test_long_chains_of_operators_constrain(members: tuple[str, ...], tmp_path: Path) -> None:
    assert in_main(tmp_path, *members)["x"] == 4


def test_many_parameters_in_one_constraint_get_values(tmp_path: Path) -> None:
    given = [f"x{number}: int with:\n    keep(it in [0..30])" for number in range(25)]
    unlike = " and ".join(f"x{one} != x{other}" for one in range(25) for other in range(one))
    found = in_main(tmp_path, *given, f"keep({unlike})")
    assert len({found[f"x{number}"] for number in range(25)}) == 25


def test_many_parameters_in_one_sum_get_values(tmp_path: Path) -> None:
    given = [f"x{number}: float with:\n    keep(it in [0..9])" for number in range(260)]
    found = in_main(tmp_path, *given, f"keep({row('+', 'x#', 260)} < 2000.0)")
    values = [found[f"x{number}"] for number in range(260)]
    assert sum(value for value in values if isinstance(value, float)) < 2000


@pytest.mark.parametrize("free", ["= 3", "with:\n        keep(it in [3..3])"], ids=["plain", "chosen"])
def test_long_chains_of_defaults_are_evaluated(free: str, tmp_path: Path) -> None:
    members = "".join(f"    x{number}: int = x{number + 1} + 1\n" for number in range(MANY))
    assert fields(tmp_path, f"scenario main:\n{members}    x{MANY}: int {free}\n")["x0"] == MANY + 3


async def test_long_chains_of_operators_run(run_text: RunText) -> None:
    run = await run_text(f"""
import osc.helpers
scenario inner:
    n: int
    do log(n)
scenario main:
    event e(n: int)
    var v: int = 1
    x: int = 7
    def f(n: int) -> int is expression {table("n == # ? # + 1 : ", "0")}
    cover(c, expression: {row("+", "v")}, range: [0..1000], every: 100)
    do serial:
        wait {table("v == # + 2 ? false : ", "true")}
        wait {row("+", "v")} == {MANY} and {row("and", "v == 1")}
        parallel:
            wait @e as o if {row("+", "o.n")} == {MANY}
            emit e(1)
        inner({row("+", "v")})
        inner(3) with:
            keep({row("+", "it.n")} == {3 * MANY})
        log(f(x))
""")
    assert [text for _, text in run.logs] == [str(MANY), "3", "8"]
