"""z3, for problems that propagation and bounded search leave undecided."""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce
from itertools import combinations
from typing import cast

import pytest

from seoro.lang.solve import (
    Cell,
    Choice,
    Conflict,
    Free,
    Integer,
    NeedsSolver,
    Real,
    Undecided,
    Value,
    attempt,
    solve,
)
from seoro.lang.solve.evaluation import holds
from seoro.lang.solve.terms import Implies, Negate, Not, Opaque, Term

from .helpers import FLOAT, INT, Operand, among, calculate, cell, compare, problem, term

HARD = "4.....8.5.3..........7......2.....6.....8.4......1.......6.3.7.5..2.....1.4......"
GRID = [cell(f"s{index}", Integer(1, 9)) for index in range(81)]


def total(*factors: int) -> Term:
    """Return a sum of integers times factors."""
    terms: list[Term] = [calculate(one, "*", factor) for one, factor in zip(UNKNOWN, factors, strict=True)]
    return reduce(lambda left, right: calculate(left, "+", right), terms)


UNKNOWN = [cell(f"n{index}", Integer(0, 10**6)) for index in range(6)]
# Too hard for bounded search: each has few solutions, which are not found by chance.
EQUATIONS = [
    compare(total(-477, -758, 15, 559, -79, -32), "==", -101426875),
    compare(total(335, -222, 616, -570, -807, 0), "==", -663736588),
    compare(total(-941, 830, 712, -201, -113, 245), "==", 752116365),
    compare(total(562, 572, -995, 426, -87, -454), "==", -204926455),
    compare(total(478, 643, -531, 211, 936, -790), "==", 854120544),
]


def sudoku(givens: str) -> list[Term]:
    units = [list(range(9 * row, 9 * row + 9)) for row in range(9)]
    units += [list(range(column, 81, 9)) for column in range(9)]
    units += [[27 * (b // 3) + 3 * (b % 3) + 9 * (k // 3) + k % 3 for k in range(9)] for b in range(9)]
    pairs = sorted({pair for unit in units for pair in combinations(sorted(unit), 2)})
    terms: list[Term] = [compare(GRID[one], "!=", GRID[other]) for one, other in pairs]
    return terms + [compare(GRID[index], "==", int(digit)) for index, digit in enumerate(givens) if digit != "."]


def test_a_hard_sudoku_is_solved() -> None:
    asked = problem(*sudoku(HARD))
    values = solve(asked, 0).values
    assert all(holds(constraint.term, values) for constraint in asked.constraints)


@pytest.mark.more
def test_an_empty_sudoku_is_filled_differently_for_each_seed() -> None:
    asked = problem(*sudoku("." * 81))
    one, other = (solve(asked, seed, engine="search").values for seed in (0, 1))
    assert one != other
    assert all(holds(constraint.term, one) for constraint in asked.constraints)


def test_a_hard_problem_without_z3_is_refused_with_the_extra_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(attempt, "find_spec", lambda name: None)
    with pytest.raises(NeedsSolver, match=r"install `seoro\[solver\]`"):
        solve(problem(*EQUATIONS), 0)


def test_a_hard_problem_is_undecided_by_search() -> None:
    with pytest.raises(Undecided, match="narrow their bounds"):
        solve(problem(*EQUATIONS), 0, engine="search")


def test_equations_of_integers_are_solved() -> None:
    values = solve(problem(*EQUATIONS), 0).values
    assert all(holds(what, values) for what in EQUATIONS)


@pytest.mark.more
def test_z3_finds_equal_values_each_time() -> None:
    asked = problem(*sudoku(HARD[:40] + "." * 41))
    first = solve(asked, 3, engine="z3").values
    solve(problem(*EQUATIONS), 3, engine="z3")
    assert solve(asked, 3, engine="z3").values == first


def test_z3_draws_values() -> None:
    x, y = cell("x", Integer(0, 1000)), cell("y", Real(0.0, 1.0))
    asked = problem(compare(calculate(x, "%", 7), "==", 3), compare(y, "<", 0.9))
    values = [solve(asked, seed, engine="z3").values for seed in range(12)]
    assert len({one[x] for one in values}) > 8
    assert len({one[y] for one in values}) == 12


@pytest.mark.parametrize("wanted", [3, -3])
def test_z3_divides_as_the_language_does(wanted: int) -> None:
    x, y = cell("x", Integer(-100, 100)), cell("y", Integer(-100, 100))
    for left in (7, -7):
        quotient = compare(calculate(left, "/", x), "==", wanted)
        remainder = compare(calculate(y, "%", x), "==", Negate(term(1), INT))
        values = solve(problem(quotient, remainder), 1, engine="z3").values
        assert holds(quotient, values) and holds(remainder, values)


def test_z3_takes_remainders_of_reals_as_the_language_does() -> None:
    x = cell("x", Real(-10.0, 10.0))
    asked = problem(compare(calculate(x, "%", 3.0, FLOAT), "<", -1.0), compare(x, ">", -9.0))
    values = solve(asked, 1, engine="z3").values
    assert all(holds(constraint.term, values) for constraint in asked.constraints)


def test_z3_chooses_strings_and_tokens() -> None:
    name, kind = cell("name", Free()), cell("kind", Choice(("a", "b", "c")))
    asked = problem(
        among(name, "a", "b", "other"),
        compare(name, "!=", kind),
        Not(compare(kind, "==", "c")),
        cells=(kind, name),
    )
    found = {tuple(solve(asked, seed, engine="z3").values.values()) for seed in range(20)}
    assert found <= {("a", "b"), ("b", "a"), ("a", "other"), ("b", "other")}
    assert len(found) > 1


def test_z3_solves_equations_of_reals() -> None:
    x, y = cell("x", Real(0.0, 10.0)), cell("y", Real(0.0, 10.0))
    product: Operand = calculate(x, "*", y, FLOAT)
    asked = problem(compare(product, "==", 2.0), compare(calculate(x, "+", y, FLOAT), "==", 3.0))
    values = solve(asked, 1, engine="z3").values
    assert sorted(cast(list[float], list(values.values()))) == pytest.approx([1.0, 2.0])


def test_models_that_fail_an_opaque_term_are_excluded() -> None:
    x, y = cell("x", Integer(1, 9)), cell("y", Integer(1, 9))

    def is_seven(values: Mapping[Cell, Value]) -> bool:
        return cast(int, values[x]) + cast(int, values[y]) == 7

    opaque = Opaque((x, y), is_seven, "x + y is seven")
    values = solve(problem(opaque, Implies(compare(x, "<", 4), compare(y, "==", 1))), 0, engine="z3").values
    assert is_seven(values)


def test_z3_proves_a_conflict() -> None:
    x, y = cell("x", Integer(1, 10**9)), cell("y", Integer(1, 10**9))
    odd, even = calculate(calculate(x, "*", 2), "+", 1), calculate(y, "*", 4)
    with pytest.raises(Conflict) as raised:
        solve(problem(compare(x, ">", 3), compare(odd, "==", even)), 0)
    assert [constraint.text for constraint in raised.value.constraints] == ["1"]
