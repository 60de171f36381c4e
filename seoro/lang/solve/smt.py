"""Solution by z3 (`seoro[solver]`) of groups that search leaves undecided, in exact arithmetic.

z3 finds a contradiction or a model. To avoid the same preferred values in each run, z3 is first offered random
values and random halves of domains, and accepts or rejects them. The model then guides the same propagation as
in search, with its rounding and its checks. Propagation also checks opaque terms and divisions by zero, which z3
does not know. A failing model is excluded, and z3 searches another one.

Results are reproducible: by a separate context, a fixed seed, and limits of work instead of time.
"""

from __future__ import annotations

from contextlib import suppress
from typing import Any, Final

import z3

from seoro.lang.solve.evaluation import TOLERANCE, holds
from seoro.lang.solve.propagate import Clash, Store
from seoro.lang.solve.search import Exhausted, GivenUp, Streams, any_of, halves, involved, next_cell, solved_for
from seoro.lang.solve.sets import Finite, Range, ValueSet, contains, is_bounded, is_narrow, members, single
from seoro.lang.solve.smt_terms import Translation
from seoro.lang.solve.terms import Opaque, Value

# Limits of the work of z3 for an answer, and for an offer, in units of z3: a million take a second or longer.
WORK: Final = 1_000_000
OFFER_WORK: Final = 100_000
# Limits of offers, and of halves offered to one cell.
OFFERS: Final = 40
HALVES: Final = 3
# Limit of models.
MODELS: Final = 64


def choose_with_z3(store: Store, group: list[int], streams: Streams) -> None:
    """Choose values for the cells of a group.

    Raises:
        Exhausted: The constraints have no solution.
        GivenUp: z3 is undecided, or its models do not hold in float arithmetic.
        Unbounded: A cell without bounds cannot be drawn.
    """
    asked = _Question(store, group)
    asked.check()
    with suppress(GivenUp):
        asked.offer(streams)
    mark = len(store.trail)
    for _ in range(MODELS):
        model = asked.model()
        try:
            return _follow(store, group, model)
        except Clash as clash:
            store.undo(mark)
            asked.exclude(model, clash.part)
    raise GivenUp


def _follow(store: Store, group: list[int], model: dict[int, Value]) -> None:
    """Assign the values of a model to the cells that stay open during propagation.

    Raises:
        Clash: The values do not hold, or propagation has excluded them.
    """
    while (cell := next_cell(store, group)) is not None:
        values = store.sets[cell]
        value = model[cell]
        if isinstance(values, Range) and (is_narrow(values) or not contains(values, value)):
            value = solved_for(store, cell, values)
        elif not contains(values, value):
            raise Clash(next(by for changed, _, _, by in reversed(store.trail) if changed == cell))
        store.assign(cell, single(value), exact=False)


class _Question:
    """A group of cells and its constraints in z3."""

    def __init__(self, store: Store, group: list[int]) -> None:
        self._store = store
        self._group = group
        closed = (cell for cell in range(len(store.cells)) if not store.is_open(cell))
        self._terms = Translation(store.values(closed))
        self._solver = z3.Solver(ctx=self._terms.context)
        self._solver.set("random_seed", 0)
        self._solver.set("rlimit", WORK)
        self._taken = 0  # number of accepted offers
        self._excluded: list[Any] = []
        self._blamed: set[int] | None = set()  # parts that excluded models; None if that proves nothing
        for cell in group:
            values = store.sets[cell]
            listed = members(values, 32)
            self._solver.add(self._terms.inside(store.cells[cell], Finite(listed) if listed else values))
        for number in store.parts_of(group):
            part = store.parts[number]
            if not any(isinstance(node.term, Opaque) for node in part.nodes):
                self._solver.assert_and_track(self._terms.holds(part.term), str(number))
        self._solver.add(*self._terms.conditions)

    def check(self) -> None:
        """Check that a model exists.

        Raises:
            Exhausted: The constraints have no model.
            GivenUp: z3 is undecided.
        """
        answer = self._solver.check()
        if answer == z3.unsat:
            raise Exhausted(frozenset(self._core()), by_z3=True)
        if answer != z3.sat:
            raise GivenUp

    def offer(self, streams: Streams) -> None:
        """Offer cells random values and halves of their domains; add the possible ones as constraints.

        Raises:
            GivenUp: z3 is undecided; earlier offers remain constraints.
        """
        self._solver.set("rlimit", OFFER_WORK)
        offers = OFFERS
        for cell in self._group:
            values = self._store.sets[cell]
            if not is_bounded(values) or offers <= 0:
                continue
            offers -= 1
            if self._take(cell, single(any_of(values, self._store, cell, streams))):
                continue
            stream = streams.of(self._store.cells[cell])
            for _ in range(HALVES):
                if not isinstance(values, Range) or values.low >= values.high or is_narrow(values):
                    break
                first, second = stream.shuffled(halves(values))
                offers -= 1
                values = first if self._take(cell, first) else second

    def model(self) -> dict[int, Value]:
        """Return values of the cells of the group, rounded to floats.

        Raises:
            Exhausted: The constraints have no further model.
            GivenUp: z3 is undecided, or exclusions prove nothing.
        """
        self._solver.set("rlimit", WORK)
        answer = self._solver.check()
        if answer != z3.sat and self._taken:
            self._solver.pop(self._taken)
            self._taken = 0
            self._solver.add(*self._excluded)
            answer = self._solver.check()
        if answer == z3.unsat and self._blamed is not None:
            raise Exhausted(frozenset(self._blamed | self._core()), by_z3=True)
        if answer != z3.sat:
            raise GivenUp
        found = self._solver.model()
        return {cell: self._value(cell, found) for cell in self._group}

    def exclude(self, model: dict[int, Value], part: int) -> None:
        """Exclude models with the same values of the cells of a part, which does not hold with them."""
        terms, store, clashed = self._terms, self._store, self._store.parts[part]
        mentioned = [cell for cell in clashed.cells if cell in model]
        values = store.values(clashed.cells) | {store.cells[cell]: model[cell] for cell in mentioned}
        if holds(clashed.term, values, TOLERANCE):
            self._blamed = None  # only the rounding of other cells
        elif self._blamed is not None:
            self._blamed |= involved(store, part)
        differ = [terms.variable(store.cells[cell]) != terms.constant(model[cell]) for cell in mentioned]
        self._excluded.append(z3.Or(*differ, terms.constant(False)))
        self._solver.add(self._excluded[-1])

    def _core(self) -> set[int]:
        """Return the parts of the contradiction that z3 found, and parts that narrowed their cells."""
        core = {int(str(name)) for name in self._solver.unsat_core()}
        return set().union(*(involved(self._store, part) for part in core)) or set(range(len(self._store.parts)))

    def _value(self, cell: int, model: Any) -> Value:
        found = self._store.cells[cell]
        return self._terms.value(found, model.eval(self._terms.variable(found), model_completion=True))

    def _take(self, cell: int, values: ValueSet) -> bool:
        """Restrict a cell if possible; return whether it is.

        Raises:
            GivenUp: z3 is undecided.
        """
        self._solver.push()
        self._solver.add(self._terms.inside(self._store.cells[cell], values))
        answer = self._solver.check()
        if answer == z3.sat:
            self._taken += 1
            return True
        self._solver.pop()
        if answer != z3.unsat:
            raise GivenUp
        return False
