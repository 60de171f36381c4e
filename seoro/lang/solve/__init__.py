"""Choice of parameter values (7.3.6, 7.3.11): finds values of cells such that all constraints on them hold.

The package knows neither trees nor plans nor the runtime. It is pure: equal problems and seeds result in equal
values on any machine. The entry point is `solve`.

Values are chosen in four steps:

1. Cells that equalities determine are computed. Most problems end here.
2. Propagation narrows the domains: ranges through arithmetic and comparisons, finite choices one by one, truth
   values through logic.
3. The seed determines the other values. All cells that share constraints are drawn together from their narrowed
   domains until the constraints hold, so that values are uniform over the solutions. A cell that an equality
   determines follows from the others. If no draw fits, cells are chosen one after the other, each uniformly from
   the values that earlier choices leave, with backtracking. Each cell has its own random stream, named by the seed
   and the cell, so that unrelated cells do not change its value.
4. If a bounded search does not decide, z3 does, if it is installed (`seoro[solver]`).

Numbers without bounds, and strings and references without an equality, are not chosen: `Unbounded` names the cell.

Equal reals are identical if they are given, drawn or computed. Where a cell was solved for, as `x` in
`3 * x == y`, the sides may differ by a relative 1e-9 (`evaluation.TOLERANCE`), since often no float satisfies the
equality exactly. Integers stay within 64 bits; only without such a solution may they wrap.
"""

# ruff: noqa: F403 - all names of problems in one place
from __future__ import annotations

from seoro.lang.solve.problem import *
from seoro.lang.solve.solver import follows as follows
from seoro.lang.solve.solver import lowest as lowest
from seoro.lang.solve.solver import solve as solve
from seoro.lang.solve.terms import *
