"""Equality of reals: exact, and except for rounding."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seoro.lang.solve import Conflict, Integer, Real, solve
from seoro.lang.solve.evaluation import holds
from seoro.lang.solve.terms import Term, ToReal

from .helpers import FLOAT, Operand, calculate, cell, compare, problem, term, within

X, Y = cell("x", Real()), cell("y", Real())


def times(left: Operand, right: Operand) -> Term:
    return calculate(left, "*", right, FLOAT)


def plus(left: Operand, right: Operand) -> Term:
    return calculate(left, "+", right, FLOAT)


def test_given_reals_are_compared_exactly() -> None:
    assert 3 * 0.1 != 0.3
    for order in (1, -1):
        with pytest.raises(Conflict):
            solve(problem(*[compare(X, "==", 0.1), compare(times(3.0, X), "==", 0.3)][::order]), 0)


def test_a_solved_real_has_the_shortest_fitting_decimal() -> None:
    assert solve(problem(compare(times(3.0, X), "==", 0.3)), 0).values[X] in (0.1, 0.3 / 3)
    assert 0.2 + 0.1 != 0.3
    assert holds(compare(plus(X, 0.1), "==", 0.3), solve(problem(compare(plus(X, 0.1), "==", 0.3)), 0).values)


def test_a_solved_real_satisfies_equalities_within_rounding() -> None:
    values = solve(problem(compare(times(3.0, X), "==", 0.3), compare(times(7.0, X), "==", 0.7)), 0).values
    assert values[X] == pytest.approx(0.1, rel=1e-12)
    root = solve(problem(compare(times(X, X), "==", 2.0), compare(X, ">", 0.0)), 0).values[X]
    assert root == pytest.approx(math.sqrt(2), rel=1e-12)


def test_a_conflict_beyond_rounding_is_found() -> None:
    with pytest.raises(Conflict):
        solve(problem(compare(times(3.0, X), "==", 0.3), compare(times(7.0, X), "==", 0.7001)), 0)


def test_two_equations_are_solved_together() -> None:
    minus = calculate(X, "-", Y, FLOAT)
    terms: list[Term] = [
        compare(plus(X, Y), "==", 1.1),
        compare(minus, "==", 0.3),
        within(X, 0.0, 1.0),
        within(Y, 0.0, 1.0),
    ]
    values = solve(problem(*terms), 0).values
    assert [values[X], values[Y]] == pytest.approx([0.7, 0.4])


def test_points_on_a_circle_are_found() -> None:
    circle = compare(plus(times(X, X), times(Y, Y)), "==", 25.0)
    for seed in range(5):
        values = solve(problem(circle, within(X, 0.0, 5.0), within(Y, -5.0, 0.0)), seed).values
        assert holds(circle, values, 1e-9)


def test_strict_bounds_are_not_reached() -> None:
    above = math.nextafter(1.0, 2.0)
    assert solve(problem(compare(X, ">", 1.0), compare(X, "<=", above)), 0).values[X] == above


def test_an_integer_converted_to_a_real_is_solved() -> None:
    number = cell("n", Integer(0, 10))
    terms: list[Term] = [compare(ToReal(term(number)), "==", times(X, 2.0)), within(X, 2.1, 2.9)]
    assert solve(problem(*terms), 0).values[number] == 5


@settings(max_examples=60, deadline=None)
@given(
    st.floats(-1e6, 1e6).filter(lambda factor: abs(factor) > 1e-3),
    st.floats(-1e6, 1e6),
    st.floats(-1e6, 1e6),
)
def test_a_line_is_solved_for_both_variables(factor: float, offset: float, result: float) -> None:
    line = compare(Y, "==", plus(times(factor, X), offset))
    values = solve(problem(line, compare(Y, "==", result)), 0).values
    assert holds(line, values, 1e-9)
    found = solve(problem(line, compare(X, "==", result)), 0).values
    assert holds(line, found)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.floats(-100, 100), st.floats(0, 100)), min_size=2, max_size=4), st.integers())
def test_a_sum_of_ranges_is_satisfied(bounds: list[tuple[float, float]], seed: int) -> None:
    cells = [cell(f"x{index}", Real()) for index in range(len(bounds))]
    total: Operand = cells[0]
    for one in cells[1:]:
        total = plus(total, one)
    middle = sum(low + width / 2 for low, width in bounds)
    ranges = [within(one, low, low + width) for one, (low, width) in zip(cells, bounds, strict=True)]
    values = solve(problem(*ranges, within(total, middle - 1, middle + 1)), seed).values
    assert all(holds(what, values) for what in (*ranges, within(total, middle - 1, middle + 1)))
