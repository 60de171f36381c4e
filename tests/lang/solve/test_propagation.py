"""Consequences of constraints without any choice."""

from __future__ import annotations

from itertools import pairwise

import pytest

from seoro.lang.solve import Boolean, Cell, Choice, Free, Integer, Real, Value, solve
from seoro.lang.solve.terms import (
    And,
    CellRef,
    Compare,
    IfThenElse,
    Implies,
    Negate,
    Not,
    Opaque,
    Or,
    Term,
    ToReal,
)

from .helpers import FLOAT, INT, UINT, among, calculate, cell, compare, problem, term, within

A, B, C = cell("a", Boolean()), cell("b", Boolean()), cell("c", Boolean())
X, Y, Z = cell("x", Integer()), cell("y", Integer()), cell("z", Integer())
U = cell("u", Integer(0, 2**64 - 1))
R, S = cell("r", Real()), cell("s", Real())
KIND = cell("kind", Choice(("city", "highway", "school")))
NAME, OTHER = cell("name", Free()), cell("other", Free())


def solved(*terms: Term, seed: int = 0) -> dict[Cell, Value]:
    return dict(solve(problem(*terms), seed).values)


@pytest.mark.parametrize(
    ("terms", "unknown", "value"),
    [
        ([compare(X, "==", 5)], X, 5),
        ([compare(5, "==", X)], X, 5),
        ([compare(X, "==", Y), compare(Y, "==", 3)], X, 3),
        ([compare(calculate(X, "+", 3), "==", 5)], X, 2),
        ([compare(calculate(3, "-", X), "==", 5)], X, -2),
        ([compare(Negate(term(X), INT), "==", 5)], X, -5),
        ([compare(calculate(X, "*", 3), "==", 12)], X, 4),
        ([compare(calculate(X, "*", -3), "==", 12)], X, -4),
        ([compare(calculate(X, "*", X), "==", 49), compare(X, "<", 0)], X, -7),
        ([compare(calculate(X, "/", 3), "==", -2), compare(X, ">=", -6)], X, -6),
        ([compare(calculate(-7, "/", 2), "==", X)], X, -3),
        ([compare(calculate(-7, "%", 2), "==", X)], X, -1),
        ([compare(calculate(X, "%", 5), "==", 3), within(X, 4, 12)], X, 8),
        ([compare(X, ">", 2), compare(X, "<", 4)], X, 3),
        ([within(X, 1, 3), compare(X, "!=", 1), compare(X, "!=", 2)], X, 3),
        ([among(X, 1, 5, 9), compare(X, ">", 5)], X, 9),
        ([Not(among(X, 1, 2)), within(X, 1, 3)], X, 3),
        ([Not(compare(X, "<=", 4)), compare(X, "<=", 5)], X, 5),
        ([compare(ToReal(term(X)), "==", 4.0)], X, 4),
        ([compare(ToReal(term(X)), "<", R), compare(R, "==", 4.5), compare(X, ">", 3)], X, 4),
        ([term(A)], A, True),
        ([Not(term(A))], A, False),
        ([And((term(A), term(B)))], B, True),
        ([Or((term(A), term(B))), Not(term(A))], B, True),
        ([Not(Or((term(A), term(B))))], B, False),
        ([Implies(term(A), term(B)), term(A)], B, True),
        ([Implies(term(A), term(B)), Not(term(B))], A, False),
        ([compare(A, "==", B), Not(term(B))], A, False),
        ([compare(A, "!=", B), Not(term(B))], A, True),
        ([compare(A, "==", compare(X, "<", 3)), compare(X, "==", 5)], A, False),
        ([compare(A, "==", compare(X, "<", 3)), term(A), compare(X, ">", 1)], X, 2),
        ([Or((compare(X, "==", 1), compare(X, "==", 2))), compare(X, "!=", 1)], X, 2),
        ([compare(X, "==", IfThenElse(term(A), term(1), term(2))), term(A)], X, 1),
        ([compare(IfThenElse(term(A), term(1), term(2)), "==", 2)], A, False),
        ([Implies(compare(KIND, "==", "city"), compare(X, "==", 3)), compare(KIND, "==", "city")], X, 3),
        ([compare(KIND, "!=", "city"), compare(KIND, "!=", "school")], KIND, "highway"),
        ([among(KIND, "school", "elsewhere")], KIND, "school"),
        ([compare(NAME, "==", "robot")], NAME, "robot"),
        ([compare(NAME, "==", OTHER), among(OTHER, "robot")], NAME, "robot"),
        (
            [compare(S, "==", calculate(calculate(2.0, "*", R, FLOAT), "+", 1.0, FLOAT)), compare(S, "==", 5.0)],
            R,
            2.0,
        ),
        (
            [compare(S, "==", calculate(calculate(2.0, "*", R, FLOAT), "+", 1.0, FLOAT)), compare(R, "==", 0.1)],
            S,
            1.2,
        ),
        ([compare(calculate(1.0, "/", R, FLOAT), "==", 4.0)], R, 0.25),
    ],
)
def test_a_value_follows_from_constraints(terms: list[Term], unknown: Cell, value: Value) -> None:
    for seed in range(3):
        assert solved(*terms, seed=seed)[unknown] == value


def test_an_opaque_term_is_computed_when_its_cells_are_known() -> None:
    text = Opaque((NAME,), lambda values: f"{values[NAME]}.goal", "name + '.goal'")
    assert solved(compare(OTHER, "==", text), compare(NAME, "==", "robot"))[OTHER] == "robot.goal"


def test_an_opaque_condition_filters_few_values() -> None:
    def is_odd(values: object) -> bool:
        assert isinstance(values, dict)
        return bool(values[X] % 2)

    assert solved(Opaque((X,), is_odd, "is_odd(x)"), within(X, 2, 4))[X] == 3


@pytest.mark.parametrize("backwards", [False, True])
def test_a_chain_of_equalities_propagates_in_both_directions(backwards: bool) -> None:
    chain = [cell(f"a{index}", Integer()) for index in range(300)]
    terms: list[Compare] = [compare(after, "==", calculate(before, "+", 1)) for before, after in pairwise(chain)]
    start = chain[-1] if backwards else chain[0]
    values = solved(*terms, compare(start, "==", 1000))
    assert [values[unknown] for unknown in chain] == [
        1000 + index - (299 if backwards else 0) for index in range(300)
    ]


def test_integers_do_not_wrap_if_another_solution_exists() -> None:
    assert solved(compare(calculate(X, "*", 2), "==", 10))[X] == 5
    assert solved(compare(calculate(U, "-", 5, UINT), "<", 3), compare(U, ">", 6))[U] == 7


def test_integers_wrap_without_another_solution() -> None:
    most, least = 2**63 - 1, -(2**63)
    assert solved(compare(calculate(X, "+", 1), "==", Y), compare(X, ">=", most))[Y] == least
    assert solved(compare(calculate(X, "+", 1), "==", least), within(Y, 0, 0))[X] == most
    assert solved(compare(calculate(U, "-", 1, UINT), "==", 2**64 - 1))[U] == 0


def test_a_conjunction_equals_its_members() -> None:
    values = solved(And((compare(X, "==", 1), And((compare(Y, "==", 2), compare(CellRef(Z), "==", X))))))
    assert (values[X], values[Y], values[Z]) == (1, 2, 1)
