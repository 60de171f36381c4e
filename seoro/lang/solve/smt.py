"""What search does not decide, asked of z3 (`seoro[solver]`), in exact arithmetic of integers and reals.

z3 says no, and then there is no solution; or it says yes with a model. So that not all is as z3 likes it best,
cells are first offered random values and random halves of what they can be, and keep what z3 says is possible. The
model then guides the same propagation that search uses, so that its rounding and its tests apply. What z3 does not
know, opaque terms and divisions by zero, is tested there as well: a model that fails is excluded, and another one
asked for.

It is the same each time: a context of its own, a fixed seed, and limits on work instead of time.
"""

from __future__ import annotations

from contextlib import suppress
from typing import Any, Final

import z3

from seoro.lang.solve.cells import Value
from seoro.lang.solve.draw import Streams
from seoro.lang.solve.evaluation import TOLERANCE, holds
from seoro.lang.solve.propagate import Clash, Store
from seoro.lang.solve.search import Exhausted, GivenUp, any_of, halves, involved, next_cell, solved_for
from seoro.lang.solve.sets import Finite, Range, ValueSet, contains, is_bounded, is_narrow, members, single
from seoro.lang.solve.smt_terms import Translation
from seoro.lang.solve.terms import Opaque

# What z3 may do for an answer, and for one to an offer, in its own units: a million take a second, or much longer.
WORK: Final = 1_000_000
OFFER_WORK: Final = 100_000
# How many random values and halves are offered, and how many halves to one cell.
OFFERS: Final = 40
HALVES: Final = 3
# How many models are asked for before giving up.
MODELS: Final = 64


def choose_with_z3(store: Store, group: list[int], streams: Streams) -> None:
    """Give the cells of a group values.

    Raises:
        Exhausted: There are none.
        GivenUp: z3 does not know, or its models do not hold when they are computed with floats.
        Unbounded: A cell has no bounds to draw from.
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
    """Give cells the values of a model, as far as propagation does not find them.

    Raises:
        Clash: They do not hold, or are not among what propagation leaves.
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
    """A group of cells and its constraints, as z3 has them."""

    def __init__(self, store: Store, group: list[int]) -> None:
        self._store = store
        self._group = group
        closed = (cell for cell in range(len(store.cells)) if not store.is_open(cell))
        self._terms = Translation(store.values(closed))
        self._solver = z3.Solver(ctx=self._terms.context)
        self._solver.set("random_seed", 0)
        self._solver.set("rlimit", WORK)
        self._taken = 0  # how many of them were taken
        self._excluded: list[Any] = []
        self._blamed: set[int] | None = set()  # by whom models were excluded; None if that was no proof
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
        """See whether there are models.

        Raises:
            Exhausted: There are none.
            GivenUp: z3 does not know.
        """
        answer = self._solver.check()
        if answer == z3.unsat:
            raise Exhausted(frozenset(self._core()), by_z3=True)
        if answer != z3.sat:
            raise GivenUp

    def offer(self, streams: Streams) -> None:
        """Offer cells random values and halves of their sets; what is possible becomes part of the question.

        Raises:
            GivenUp: It is too hard to tell; what was possible so far remains part of the question.
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
        """Values for the cells of the group, rounded to floats.

        Raises:
            Exhausted: There are none any more.
            GivenUp: There may be none, or z3 does not know.
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
        """Ask for models that differ from one in what a part mentions, with which it did not hold."""
        terms, store, clashed = self._terms, self._store, self._store.parts[part]
        mentioned = [cell for cell in clashed.cells if cell in model]
        values = store.values(clashed.cells) | {store.cells[cell]: model[cell] for cell in mentioned}
        if holds(clashed.term, values, TOLERANCE):
            self._blamed = None  # it was the rounding of others
        elif self._blamed is not None:
            self._blamed |= involved(store, part)
        differ = [terms.variable(store.cells[cell]) != terms.constant(model[cell]) for cell in mentioned]
        self._excluded.append(z3.Or(*differ, terms.constant(False)))
        self._solver.add(self._excluded[-1])

    def _core(self) -> set[int]:
        """The parts that z3 needed to find that there is no model, and those that narrowed their cells."""
        core = {int(str(name)) for name in self._solver.unsat_core()}
        return set().union(*(involved(self._store, part) for part in core)) or set(range(len(self._store.parts)))

    def _value(self, cell: int, model: Any) -> Value:
        found = self._store.cells[cell]
        return self._terms.value(found, model.eval(self._terms.variable(found), model_completion=True))

    def _take(self, cell: int, values: ValueSet) -> bool:
        """Restrict a cell, if z3 finds that possible.

        Raises:
            GivenUp: That is too hard to tell.
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
