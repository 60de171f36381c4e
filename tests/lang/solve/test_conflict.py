"""Conflicts: the fewest constraints that clash, and the domains that take part."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import pytest

from seoro.lang.solve import Boolean, Cell, Choice, Conflict, Constraint, Integer, Problem, Real, Value, solve
from seoro.lang.solve.terms import And, Compare, Implies, Opaque, Term, Unevaluable

from .helpers import FLOAT, UINT, calculate, cell, compare, keep, problem, term, within

X, Y, Z = cell("x", Integer()), cell("y", Integer()), cell("z", Integer())
U = cell("u", Integer(0, 2**64 - 1))
R, S, T = cell("r", Real()), cell("s", Real()), cell("t", Real())
KIND = cell("kind", Choice(("a", "b", "c")))
A, B = cell("a", Boolean()), cell("b", Boolean())


def conflict(*terms: Term) -> Conflict:
    with pytest.raises(Conflict) as raised:
        solve(problem(*terms), 0)
    return raised.value


def names(found: Conflict) -> list[int]:
    return [int(constraint.text) for constraint in found.constraints]


def test_the_conflict_of_the_example_in_the_standard_is_found() -> None:
    assert names(conflict(compare(X, "<", 3), compare(X, "==", 2), compare(X, "==", 5))) in ([0, 2], [1, 2])


@pytest.mark.parametrize(
    ("terms", "expected"),
    [
        ([compare(X, "==", 1), compare(Y, "==", 7), compare(X, "==", 2)], [0, 2]),
        ([compare(X, "==", Y), compare(Y, "==", Z), compare(Z, "==", 1), compare(X, "==", 2)], [0, 1, 2, 3]),
        ([compare(X, "==", Y), compare(Y, "==", Z), compare(X, "<", 1), within(X, 2, 3)], [2, 3]),
        ([compare(X, ">", X)], [0]),
        ([compare(1, "==", 2), compare(X, "==", 1)], [0]),
        ([And((compare(X, "==", 1), compare(Y, "==", 1))), compare(Y, "==", 2)], [0, 1]),
        ([term(A), Implies(term(A), term(B)), compare(A, "!=", B), compare(X, "==", 1)], [0, 1, 2]),
        ([within(X, 0, 10**9), within(Y, 0, 10**9), compare(X, "<", Y), compare(Y, "<", X)], [2, 3]),
        ([compare(X, "<", Y), compare(Y, "<=", Z), compare(Z, "<=", X), within(X, 0, 9)], [0, 1, 2]),
        (
            [
                *(within(one, 0.0, 1.0) for one in (R, S, T)),
                compare(R, "<", S),
                compare(calculate(S, "+", 0.1, FLOAT), "<=", T),
                compare(T, "<", R),
            ],
            [3, 4, 5],
        ),
    ],
)
def test_a_conflict_is_minimal(terms: list[Term], expected: list[int]) -> None:
    assert names(conflict(*terms)) == expected


def test_a_smaller_conflict_is_preferred() -> None:
    chain = [cell(f"c{index}", Integer()) for index in range(6)]
    terms: list[Compare] = [compare(one, "==", other) for one, other in pairwise(chain)]
    found = conflict(compare(chain[0], "==", 1), *terms, compare(chain[5], "==", 2), compare(chain[0], "==", 3))
    assert names(found) == [0, 7]


def test_constraints_of_a_conflict_are_in_source_order() -> None:
    late, early = keep(compare(X, "==", 1), "late", place=50), keep(compare(X, "==", 2), "early", place=3)
    with pytest.raises(Conflict) as raised:
        solve(Problem((X,), (late, early)), 0)
    assert raised.value.constraints == (early, late)
    assert str(raised.value) == "these constraints contradict each other: early, late"


def test_a_conflict_that_needs_search_is_found() -> None:
    holes = [cell(f"p{index}", Choice(("a", "b", "c"))) for index in range(4)]
    differ = [compare(one, "!=", other) for index, one in enumerate(holes) for other in holes[index + 1 :]]
    found = conflict(*differ, compare(KIND, "==", "a"))
    assert names(found) == list(range(6))
    assert found.limits == tuple(holes)


@pytest.mark.parametrize(
    ("terms", "limits"),
    [
        ([compare(U, "<", 0)], (U,)),
        ([compare(KIND, "!=", "a"), compare(KIND, "!=", "b"), compare(KIND, "!=", "c")], (KIND,)),
        ([compare(KIND, "==", "d")], (KIND,)),
        ([compare(cell("v", Real(0.0, 10.0)), ">", 11.0)], None),
        ([compare(X, "==", 1), compare(X, "==", 2)], ()),
        ([compare(calculate(U, "/", 2, UINT), "==", 3), compare(U, "<", 5)], ()),
    ],
)
def test_a_conflict_lists_the_domains_that_take_part(terms: list[Term], limits: tuple[Cell, ...] | None) -> None:
    found = conflict(*terms)
    assert len(found.constraints) == len(terms)
    assert len(found.limits) == 1 if limits is None else found.limits == limits


def test_a_conflict_has_the_reason_of_a_missing_value() -> None:
    found = conflict(compare(calculate(X, "/", Y), "==", 1), compare(Y, "==", 0), within(X, 0, 3))
    assert (names(found), found.reason) == ([0, 1, 2], "division of an integer by zero")

    def refuse(values: Mapping[Cell, Value]) -> Value:
        raise Unevaluable("no such thing")

    assert conflict(Opaque((X,), refuse, "f(x)"), compare(X, "==", 3)).reason == "no such thing"


def test_a_long_conflict_is_found_in_bounded_time() -> None:
    chain = [cell(f"c{index}", Integer()) for index in range(1000)]
    terms: list[Compare] = [compare(one, "==", other) for one, other in pairwise(chain)]
    found = conflict(compare(chain[0], "==", 1), *terms, compare(chain[-1], "==", 2), compare(U, "==", 3))
    assert names(found) == list(range(1001))


def test_a_conflict_in_a_large_problem_is_minimal() -> None:
    cells = [cell(f"c{index}", Integer()) for index in range(500)]
    asked = [keep(within(one, index, index + 9), str(index), index) for index, one in enumerate(cells)]
    asked.append(keep(compare(cells[100], "<", cells[300]), "500", 500))
    asked.append(keep(compare(cells[100], ">", 200), "501", 501))
    with pytest.raises(Conflict) as raised:
        solve(Problem(tuple(cells), tuple[Constraint, ...](asked)), 0)
    assert names(raised.value) == [100, 501]
