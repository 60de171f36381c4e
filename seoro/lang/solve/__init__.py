"""Choosing parameter values (7.3.6, 7.3.11): cells with domains, constraints as terms over them, values for cells.

This room knows neither the tree nor the plan nor the runtime; it is pure, and the same problem and seed give the
same values on any machine. `solve` is all there is to call.

How values are chosen:

1. What equalities say is computed. Most problems end here.
2. Propagation narrows what each cell can be: ranges through arithmetic and comparisons, finite choices one by one,
   truth values through logic.
3. What is left is drawn from the seed, uniformly over the solutions where drawing and throwing away finds one: all
   cells that constraints tie together are drawn at once from what propagation left them, and again until they fit.
   A cell that an equality fixes follows from the others and is not drawn. Where no draw fits, cells are chosen one
   after the other, uniformly from what the earlier choices leave, with backtracking. Each cell draws from a stream
   of its own, named by the seed and the cell: a cell that has nothing to do with another does not change what the
   other is given.
4. What a bounded search does not decide is left to z3, if it is installed (`seoro[solver]`).

A number that is not bounded on both sides, and a string or a reference that nothing is equal to, is never made up:
`Unbounded` says which.

Equal reals are equal to the bit where they are given, drawn or computed. Where a cell had to be solved for, as `x`
in `3 * x == y`, the equality may be off by a relative 1e-9 (`evaluation.TOLERANCE`): often no float satisfies it
exactly. Integers are sought that do not leave their 64 bits; only if there are none may they wrap.
"""

from __future__ import annotations

from seoro.lang.solve.cells import Boolean, Cell, Choice, Domain, Free, Integer, Real, Value
from seoro.lang.solve.problem import (
    Conflict,
    Constraint,
    NeedsSolver,
    Problem,
    Solution,
    Strength,
    Unbounded,
    Undecided,
    Unsolved,
)
from seoro.lang.solve.solver import follows, lowest, solve

__all__ = [
    "Boolean",
    "Cell",
    "Choice",
    "Conflict",
    "Constraint",
    "Domain",
    "Free",
    "Integer",
    "NeedsSolver",
    "Problem",
    "Real",
    "Solution",
    "Strength",
    "Unbounded",
    "Undecided",
    "Unsolved",
    "Value",
    "follows",
    "lowest",
    "solve",
]
