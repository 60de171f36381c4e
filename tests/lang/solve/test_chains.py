"""Long chains of equalities: the steps grow with the length of the chain, not with its square."""

from __future__ import annotations

import random
from collections.abc import Callable
from itertools import pairwise

import pytest

from seoro.lang.solve import Cell, Real, linear, solve, solver
from seoro.lang.solve.evaluation import holds
from seoro.lang.solve.propagate import Store
from seoro.lang.solve.terms import Term

from .helpers import FLOAT, calculate, cell, compare, problem, within

SHORT, LONG = 50, 400


def chain(length: int, anchor: str, shuffled: bool) -> tuple[tuple[Cell, ...], list[Term]]:
    cells = tuple(cell(f"a{number}", Real()) for number in range(length))
    first, last, middle = cells[0], cells[-1], cells[length // 2]
    terms: list[Term] = [compare(one, "==", calculate(other, "+", 1.0, FLOAT)) for one, other in pairwise(cells)]
    anchors: dict[str, Term] = {
        "first": compare(first, "==", 5.0),
        "middle": compare(middle, "==", 5.0),
        "last": compare(last, "==", 5.0),
        "sum": compare(calculate(first, "+", last, FLOAT), "==", 5.0),
        "range": within(first, 0.0, 9.0),
    }
    terms.append(anchors[anchor])
    if shuffled:
        random.Random(7).shuffle(terms)
    return cells, terms


class Steps:
    """A counter of the steps of the solver."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.count = 0
        for owner, name in (
            (Store, "_revise"),
            (Store, "is_open"),
            (linear._Elimination, "_eliminate"),
            (solver, "_follow"),
        ):
            patch.setattr(owner, name, self._counted(getattr(owner, name)))

    def _counted(self, function: Callable[..., object]) -> Callable[..., object]:
        def counted(*arguments: object) -> object:
            self.count += 1
            return function(*arguments)

        return counted

    def of(self, length: int, anchor: str, shuffled: bool) -> int:
        self.count = 0
        cells, terms = chain(length, anchor, shuffled)
        found = solve(problem(*terms, cells=cells), 1).values
        assert all(holds(term, found, 1e-9) for term in terms)
        return self.count


@pytest.mark.parametrize("shuffled", [False, True], ids=["in order", "shuffled"])
@pytest.mark.parametrize("anchor", ["first", "middle", "last", "sum", "range"])
def test_steps_grow_linearly_with_the_length_of_a_chain(
    anchor: str, shuffled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps = Steps(monkeypatch)
    # Eight times as long takes about eight times as many steps, not 64; failed draws add up to a fixed number.
    assert steps.of(LONG, anchor, shuffled) < 3 * LONG / SHORT * steps.of(SHORT, anchor, shuffled)
