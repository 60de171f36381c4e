"""Drawn values: their range, their distribution, and reproducibility."""

from __future__ import annotations

import statistics
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from typing import cast

import pytest

from seoro.lang.solve import Boolean, Cell, Choice, Free, Integer, Problem, Real, Unbounded, Value, solve
from seoro.lang.solve.terms import Implies, Not, Or

from .helpers import FLOAT, among, calculate, cell, compare, problem, term, within

SEEDS = 600
N, M = cell("i", Integer()), cell("j", Integer())
X, Y = cell("x", Real()), cell("y", Real())
A = cell("a", Boolean())


def drawn(asked: Problem, what: Callable[[dict[Cell, Value]], Value]) -> Counter[Value]:
    """Count the values of many seeds."""
    return Counter(what(dict(solve(asked, seed).values)) for seed in range(SEEDS))


def is_uniform(counts: Counter[Value], kinds: int) -> bool:
    """Return whether all kinds are about equally frequent, with a chi-square limit of 1 in 10,000."""
    expected = SEEDS / kinds
    chi_square = sum((count - expected) ** 2 / expected for count in counts.values())
    chi_square += (kinds - len(counts)) * expected
    degrees = kinds - 1
    limit = degrees * (1 - 2 / (9 * degrees) + 3.72 * (2 / (9 * degrees)) ** 0.5) ** 3  # Wilson and Hilferty
    return bool(chi_square < limit)


def test_the_uniformity_test_distinguishes_distributions() -> None:
    assert is_uniform(Counter(dict.fromkeys(range(6), 100)), 6)
    assert not is_uniform(Counter({0: 150, **dict.fromkeys(range(1, 6), 90)}), 6)


@pytest.mark.parametrize(
    ("asked", "what", "kinds"),
    [
        (problem(cells=(A,)), lambda values: values[A], 2),
        (problem(cells=(cell("k", Choice(("a", "b", "c"))),)), lambda values: next(iter(values.values())), 3),
        (problem(within(N, 3, 12)), lambda values: values[N], 10),
        (problem(among(N, 1, 5, 9, 9)), lambda values: values[N], 3),
        (problem(among(cell("s", Free()), "a", "b")), lambda values: next(iter(values.values())), 2),
        (problem(within(N, 1, 10), compare(N, "!=", 4)), lambda values: values[N], 9),
        (problem(within(N, 1, 10**6), compare(calculate(N, "%", 5), "!=", 0)), lambda values: values[N] % 5, 4),
        (problem(within(N, 0, 4), within(M, 0, 4), compare(N, "<", M)), lambda values: (values[N], values[M]), 10),
        (problem(within(N, 0, 3), compare(M, "==", calculate(N, "*", N))), lambda values: values[M], 4),
        (problem(within(N, 0, 4), compare(calculate(N, "+", M), "==", 9)), lambda values: values[M], 5),
        (
            problem(Implies(term(A), compare(N, "==", 0)), within(N, 0, 3)),
            lambda values: (values[A], values[N]),
            5,
        ),
        (
            problem(Or((compare(N, "==", 1), compare(N, "==", 2), compare(N, "==", 7)))),
            lambda values: values[N],
            3,
        ),
    ],
)
def test_draws_are_uniform_over_the_solutions(
    asked: Problem, what: Callable[[dict[Cell, Value]], Value], kinds: int
) -> None:
    assert is_uniform(drawn(asked, what), kinds)


def test_reals_are_drawn_uniformly_from_their_range() -> None:
    def tenth(values: dict[Cell, Value]) -> int:
        return int(10 * (cast(float, values[X]) - 2.0) / 2.0)

    assert is_uniform(drawn(problem(within(X, 2.0, 4.0)), tenth), 10)


def test_reals_in_order_are_drawn_uniformly_from_the_triangle() -> None:
    asked = problem(within(X, 0.0, 1.0), within(Y, 0.0, 1.0), compare(X, "<", Y))
    values = [solve(asked, seed).values for seed in range(SEEDS)]
    assert statistics.fmean(one[X] for one in values) == pytest.approx(1 / 3, abs=0.03)  # type: ignore[misc]
    assert statistics.fmean(one[Y] for one in values) == pytest.approx(2 / 3, abs=0.03)  # type: ignore[misc]


def test_the_first_term_of_a_sum_is_drawn_and_the_last_follows() -> None:
    asked = problem(within(X, 1.0, 5.0), compare(calculate(X, "+", Y, FLOAT), "==", 10.0))
    values = [solve(asked, seed).values for seed in range(20)]
    assert len({one[X] for one in values}) == 20
    assert all(one[X] + one[Y] == pytest.approx(10.0) for one in values)  # type: ignore[operator]


def test_the_same_seed_gives_the_same_values() -> None:
    asked = problem(within(X, 0.0, 1.0), within(N, 1, 6), cells=(A,))
    assert solve(asked, 7).values == solve(asked, 7).values
    assert solve(asked, 7).values != solve(asked, 8).values


def test_values_are_equal_on_all_machines() -> None:
    """The expected values must never change, nor depend on the order of hashes."""
    asked = problem(within(X, 0.0, 1.0), within(N, 1, 1000), cells=(A, cell("kind", Choice(("a", "b", "c")))))
    assert list(solve(asked, 42).values.values()) == [False, "b", 0.943106223727047, 599]


SCRIPT = """
from tests.lang.solve.helpers import among, cell, compare, problem, within
from seoro.lang.solve import Choice, Integer, solve
names = [cell(f"n{index}", Choice(("a", "b", "c", "d"))) for index in range(6)]
terms = [compare(one, "!=", other) for one, other in zip(names, names[1:])]
print(list(solve(problem(*terms, among(names[0], "d", "c")), 3).values.values()))
"""


def test_values_do_not_depend_on_the_hash_seed() -> None:
    results = {
        subprocess.run(
            [sys.executable, "-c", SCRIPT],
            env={"PYTHONHASHSEED": seed},
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        for seed in ("1", "2")
    }
    assert len(results) == 1


def test_unrelated_cells_do_not_change_a_value() -> None:
    alone = solve(problem(within(X, 0.0, 1.0), compare(X, "<", Y), within(Y, 0.0, 1.0)), 5).values
    more = solve(
        problem(within(N, 1, 6), within(X, 0.0, 1.0), compare(X, "<", Y), within(Y, 0.0, 1.0), cells=(A,)), 5
    ).values
    assert (alone[X], alone[Y]) == (more[X], more[Y])


def test_two_cells_with_one_name_are_refused() -> None:
    with pytest.raises(ValueError, match="two cells are named 'x'"):
        solve(problem(within(X, 0.0, 1.0), within(cell("x", Real()), 0.0, 1.0)), 0)


@pytest.mark.parametrize(
    "asked",
    [
        problem(cells=(X,)),
        problem(compare(X, ">", 0.0)),
        problem(cells=(N,)),
        problem(compare(N, "<", 5)),
        problem(cells=(cell("u", Integer(0, 2**64 - 1)),)),
        problem(cells=(cell("s", Free()),)),
        problem(compare(cell("s", Free()), "!=", "a")),
        problem(compare(X, "==", Y)),
    ],
)
def test_unbounded_cells_are_refused(asked: Problem) -> None:
    with pytest.raises(Unbounded) as raised:
        solve(asked, 0)
    assert raised.value.cell is asked.cells[0]
    assert "give it a default, a constraint or an override" in str(raised.value)


def test_bounds_may_come_from_other_cells() -> None:
    asked = problem(compare(X, ">", 0.0), compare(X, "<", Y), within(Y, 1.0, 2.0))
    assert 0.0 < solve(asked, 0).values[X] < 2.0  # type: ignore[operator]


def test_bounds_may_come_from_a_choice() -> None:
    asked = problem(Implies(term(A), compare(X, "==", 1.0)), Implies(Not(term(A)), within(X, 5.0, 6.0)))
    values = [solve(asked, seed).values for seed in range(20)]
    assert {one[A] for one in values} == {True, False}
    assert all(one[X] == 1.0 if one[A] else 5.0 <= one[X] <= 6.0 for one in values)  # type: ignore[operator]
