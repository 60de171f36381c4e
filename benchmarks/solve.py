"""Time of solving constraints on parameters, for usual sizes and larger ones.

    python benchmarks/solve.py [--repeat N]

Each problem is solved N times with different seeds; the median and the longest processor time are printed.
"""

from __future__ import annotations

import argparse
import contextlib
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from itertools import combinations, pairwise

from seoro.lang.arithmetic import Number
from seoro.lang.solve import Cell, Conflict, Constraint, Domain, Integer, Problem, Real, solve
from seoro.lang.solve.terms import Arithmetic, CellRef, Compare, Const, InRange, Relation, Term, cells_of
from seoro.lang.source import SourceFile, Span

NOWHERE = Span(SourceFile("benchmark", ""), 0, 0)


def cells(count: int, domain: Domain) -> list[Cell]:
    """Unknowns of one kind."""
    return [Cell(f"x{index}", NOWHERE, domain) for index in range(count)]


def compare(left: Cell, relation: Relation, right: Term) -> Compare:
    """A comparison with a cell on the left."""
    return Compare(relation, CellRef(left), right)


def within(cell: Cell, low: float, high: float) -> InRange:
    """A range for a cell."""
    return InRange(CellRef(cell), Const(low), Const(high))


def problem(terms: Sequence[Term]) -> Problem:
    """The problem of some constraints and their cells."""
    found = dict.fromkeys(cell for term in terms for cell in cells_of(term))
    return Problem(tuple(found), tuple(Constraint(term, NOWHERE, str(index)) for index, term in enumerate(terms)))


def equalities() -> Problem:
    """Five cells with literals: what most scenarios have."""
    return problem([compare(cell, "==", Const(index)) for index, cell in enumerate(cells(5, Integer()))])


def ranges() -> Problem:
    """Five reals, each drawn from a range."""
    return problem([within(cell, 0.0, 1.0) for cell in cells(5, Real())])


def ordered() -> Problem:
    """Four reals in a range, each below the next."""
    some = cells(4, Real())
    return problem(
        [within(cell, 0.0, 1.0) for cell in some]
        + [compare(one, "<", CellRef(other)) for one, other in pairwise(some)]
    )


def many() -> Problem:
    """A thousand cells with a constraint each, in turn a literal, a range, and a relation to the one before."""
    terms: list[Term] = []
    some = cells(1000, Integer())
    for index, cell in enumerate(some):
        if index % 3 == 0:
            terms.append(compare(cell, "==", Const(index)))
        elif index % 3 == 1:
            terms.append(within(cell, 0, index))
        else:
            terms.append(compare(cell, "==", Arithmetic("+", CellRef(some[index - 1]), Const(1), Number.INT)))
    return problem(terms)


def chain(known: int) -> Problem:
    """Two hundred cells, each one more than the one before; one of them is known."""
    some = cells(200, Integer())
    terms: list[Term] = [
        compare(after, "==", Arithmetic("+", CellRef(before), Const(1), Number.INT))
        for before, after in pairwise(some)
    ]
    return problem([*terms, compare(some[known], "==", Const(0))])


def sudoku(givens: str) -> Problem:
    """81 cells, of which those of a row, a column or a block differ."""
    some = cells(81, Integer(1, 9))
    rows = [range(9 * row, 9 * row + 9) for row in range(9)]
    columns = [range(column, 81, 9) for column in range(9)]
    blocks = [[27 * (b // 3) + 3 * (b % 3) + 9 * (k // 3) + k % 3 for k in range(9)] for b in range(9)]
    pairs = sorted({pair for unit in (*rows, *columns, *blocks) for pair in combinations(sorted(unit), 2)})
    terms: list[Term] = [compare(some[one], "!=", CellRef(some[other])) for one, other in pairs]
    terms += [compare(some[index], "==", Const(int(digit))) for index, digit in enumerate(givens) if digit != "."]
    return problem(terms)


def clash() -> Problem:
    """A thousand cells as in `many`, and two constraints too many."""
    asked = many()
    some = asked.cells[0]
    extra = [Constraint(compare(some, "==", Const(7)), NOWHERE, "one too many")]
    return Problem(asked.cells, (*asked.constraints, *extra))


PROBLEMS: dict[str, Callable[[], Problem]] = {
    "5 literals": equalities,
    "5 ranges": ranges,
    "4 reals in order": ordered,
    "1,000 cells": many,
    "1,000 cells, a conflict": clash,
    "chain of 200, first known": lambda: chain(0),
    "chain of 200, last known": lambda: chain(199),
    "sudoku, 30 given": lambda: sudoku(
        "53..7....6..195....98....6.8...6...34..8.3..17...2...6.6....28....419..5....8..79"
    ),
    "sudoku, 17 given": lambda: sudoku(
        "4.....8.5.3..........7......2.....6.....8.4......1.......6.3.7.5..2.....1.4......"
    ),
}


def measure(asked: Problem, seed: int) -> float:
    """Return the processor time of one solution, or of proving that none exists [s]."""
    start = time.process_time()
    with contextlib.suppress(Conflict):
        solve(asked, seed)
    return time.process_time() - start


def import_time() -> float:
    """Wall time [s] of importing the package in a process of its own."""
    code = "import time; s = time.perf_counter(); import seoro.lang.solve; print(time.perf_counter() - s)"
    found = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    return float(found.stdout)


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0] if __doc__ else None)
    parser.add_argument("--repeat", type=int, default=7, metavar="N")
    repeat = parser.parse_args().repeat
    print(f"{'import':28}{1e3 * statistics.median(import_time() for _ in range(3)):10.2f} ms")
    for name, make in PROBLEMS.items():
        asked = make()
        times = [measure(asked, seed) for seed in range(repeat)]
        print(f"{name:28}{1e3 * statistics.median(times):10.2f} ms, at most {1e3 * max(times):.2f} ms")
    return 0


if __name__ == "__main__":
    sys.exit(main())
