"""Propagation: narrows the domains of cells until no constraint narrows them further.

Each part is contracted from the leaves up and from the root down. If that is coarse, and one open cell has few
values, these are tried one by one. A change wakes the parts that share the cell. Sweeps over waiting parts change
their direction in turn, so that one sweep suffices for a chain of cells in either direction.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

from seoro.lang.solve.contract import backward, forward
from seoro.lang.solve.evaluation import TOLERANCE, evaluate
from seoro.lang.solve.parts import Part
from seoro.lang.solve.sets import (
    FALSE,
    MISSING,
    TRUE,
    Empty,
    Range,
    ValueSet,
    contains,
    filtered,
    is_narrow,
    meet,
    members,
    only,
    single,
    union,
)
from seoro.lang.solve.terms import Arithmetic, Cell, Implies, Negate, Or, Term, ToWhole, Unevaluable, Value

# Number of times that any change of a cell wakes other parts; afterwards only large steps do. Otherwise `a < b`
# and `b < a` would continue number by number.
PATIENCE: Final = 32
LARGE_STEP: Final = 0.9


class Clash(Exception):
    """A part cannot hold; `part` is its number."""

    def __init__(self, part: int) -> None:
        super().__init__(part)
        self.part = part


class Store:
    """Current domains of the cells, with a trail that can undo changes.

    Args:
        cells: The cells, by number.
        parts: Parts of the constraints.
        sets: Initial domains.
        wrapping: Whether integers may exceed 64 bits and wrap.
    """

    def __init__(
        self, cells: tuple[Cell, ...], parts: tuple[Part, ...], sets: list[ValueSet], wrapping: bool
    ) -> None:
        self.cells = cells
        self.numbers = {cell: number for number, cell in enumerate(cells)}
        self.parts = parts
        self.sets = sets
        # Whether the value of a cell is given, drawn, or computed from such values, and not solved for.
        self.exact = [False] * len(cells)
        self.wrapping = wrapping
        self.trail: list[tuple[int, ValueSet, bool, int]] = []  # cell, previous state, narrowing part
        self.entailed: set[int] = set()
        self.effort = 0  # number of examined terms
        self.remarks: dict[int, str] = {}  # reasons of unevaluable parts
        self.watchers: list[list[int]] = [[] for _ in cells]
        for number, part in enumerate(parts):
            for cell in part.cells:
                self.watchers[cell].append(number)

    def is_open(self, cell: int) -> bool:
        """Return whether a cell has several possible values."""
        return only(self.sets[cell]) is MISSING

    def parts_of(self, cells: Iterable[int]) -> list[int]:
        """Return the numbers of the parts with any of the cells, in order, except entailed ones."""
        return sorted({part for cell in cells for part in self.watchers[cell]} - self.entailed)

    def values(self, cells: Iterable[int]) -> dict[Cell, Value]:
        """Return the values of known cells."""
        return {self.cells[cell]: only(self.sets[cell]) for cell in cells}

    def narrow(self, cell: int, values: ValueSet, part: int, exact: bool = False) -> None:
        """Replace the domain of a cell by a subset."""
        self.trail.append((cell, self.sets[cell], self.exact[cell], part))
        self.sets[cell] = values
        self.exact[cell] = exact

    def undo(self, mark: int) -> None:
        """Undo the changes since the trail had this length."""
        while len(self.trail) > mark:
            cell, values, exact, _ = self.trail.pop()
            self.sets[cell] = values
            self.exact[cell] = exact

    def assign(self, cell: int, values: ValueSet, exact: bool) -> None:
        """Restrict a cell, and propagate.

        Raises:
            Clash: A part cannot hold.
        """
        self.narrow(cell, values, -1, exact)
        self.propagate(self.watchers[cell])

    def propagate(self, woken: Iterable[int]) -> None:
        """Contract the given parts, and parts that their changes wake.

        Raises:
            Clash: A part cannot hold.
        """
        waiting = {part for part in woken if part not in self.entailed}
        narrowed: dict[int, int] = {}
        backwards = False
        while waiting:
            for number in sorted(waiting, reverse=backwards):
                waiting.discard(number)
                for cell, before in self._revise(number):
                    if is_narrow(before) and self.is_open(cell):
                        continue  # only rounding, which would propagate through whole chains for each choice
                    narrowed[cell] = narrowed.get(cell, 0) + 1
                    if narrowed[cell] <= PATIENCE or _is_large_step(before, self.sets[cell]):
                        waiting.update(self.watchers[cell])
                if not self.parts[number].listed:
                    waiting.discard(number)  # once is enough
            waiting -= self.entailed
            backwards = not backwards

    def _revise(self, number: int) -> list[tuple[int, ValueSet]]:
        """Contract one part; return the narrowed cells with their previous domains."""
        self.effort += len(self.parts[number].nodes)
        part = self.parts[number]
        still_open = [cell for cell in part.cells if self.is_open(cell)]
        if not still_open:
            self._verify(number)
            return []
        try:
            changes = self._narrowed(number, still_open)
        except Empty:
            if self._is_solved_for(part):
                return []  # possibly rounding: decided when all cells are known
            raise Clash(number) from None
        if changes and not any(self.is_open(cell) for cell in still_open):
            self._verify(number)
        return changes

    def _narrowed(self, number: int, still_open: list[int]) -> list[tuple[int, ValueSet]]:
        part = self.parts[number]
        if len(still_open) > 1:
            return self._contract(number)
        for cell, definition in part.definitions:
            if cell == still_open[0]:
                return self._compute(number, cell, definition)
        changes = self._contract(number)
        return [*changes, *self._list(number, still_open[0])] if part.listed else changes

    def _verify(self, number: int) -> None:
        """Evaluate a part with known cells."""
        part = self.parts[number]
        self.effort += part.cost
        try:
            if evaluate(part.term, self.values(part.cells), self._tolerance(part)) is True:
                return
        except Unevaluable as reason:
            self.remarks[number] = str(reason)
        raise Clash(number)

    def _tolerance(self, part: Part) -> float:
        return TOLERANCE if self._is_solved_for(part) else 0.0

    def _is_solved_for(self, part: Part) -> bool:
        """Return whether the value of a real cell of a part was solved for."""
        return any(not self.exact[cell] and isinstance(only(self.sets[cell]), float) for cell in part.cells)

    def settle(self) -> None:
        """Mark the parts that hold for all values of open cells as entailed; called before any choice."""
        for number, part in enumerate(self.parts):
            found = self._forward(part)
            holds_anyhow = not part.partial and found[-1] == TRUE and not self._overflowing(part, found)
            if holds_anyhow or not any(self.is_open(cell) for cell in part.cells):
                self.entailed.add(number)

    def _forward(self, part: Part) -> list[ValueSet]:
        """Return the possible values of each term of a part."""
        found: list[ValueSet] = []
        for node in part.nodes:
            if node.cell >= 0:
                found.append(self.sets[node.cell])
            elif node.args:
                found.append(forward(node.term, [found[arg] for arg in node.args], self.wrapping))
            else:
                found.append(node.constant)
        return found

    def _overflowing(self, part: Part, found: list[ValueSet]) -> frozenset[int]:
        """Return the positions of the terms of a part that some values take beyond 64 bits.

        Without wrapping, these values are left out of `found`, though the cells still have them.
        """
        if self.wrapping:
            return frozenset()
        return frozenset(
            place
            for place, node in enumerate(part.nodes)
            if isinstance(node.term, Arithmetic | Negate | ToWhole)
            and forward(node.term, [found[arg] for arg in node.args], wrapping=True) != found[place]
        )

    def _contract(self, number: int) -> list[tuple[int, ValueSet]]:
        """Narrow the cells of a part by contraction of its terms."""
        part = self.parts[number]
        found = self._forward(part)
        overflowing = frozenset[int]()
        if found[-1] == TRUE:
            if not part.conditional:
                overflowing = self._overflowing(part, found)
            if not overflowing:
                return []
        changes: list[tuple[int, ValueSet]] = []
        for cell, after in self._united(part, found, overflowing).items():
            before = self.sets[cell]
            if after != before:
                self.narrow(cell, after, number)
                changes.append((cell, before))
        return changes

    def _united(self, part: Part, found: list[ValueSet], overflowing: frozenset[int]) -> dict[int, ValueSet]:
        """Return the domains of the cells of a part, united over the cases of an alternative.

        Args:
            part: The part.
            found: Possible values of its terms.
            overflowing: Positions of terms whose operands are narrowed to those without overflow.

        Raises:
            Empty: The part cannot hold.
        """
        whole = part.nodes[-1]
        match whole.term:
            case Or():
                cases = [(arg, TRUE) for arg in whole.args]
            case Implies():
                cases = [(whole.args[0], FALSE), (whole.args[1], TRUE)]
            case _:
                cases = [(len(found) - 1, TRUE)]
        united: dict[int, ValueSet] | None = None
        start = 0
        for place, wanted in cases:
            first, start = start, place + 1  # the terms of a case are consecutive, the case last
            if wanted == TRUE and found[place] == FALSE:
                continue
            try:
                case = self._backward(part, found, overflowing, first, place, wanted)
            except Empty:
                continue
            if united is None:
                united = case
            else:
                united = {cell: union(values, case[cell]) for cell, values in united.items() if cell in case}
            if not united:
                return {}  # the cases have no cell in common
        if united is None:
            raise Empty
        return {cell: meet(self.sets[cell], values) for cell, values in united.items()}

    def _backward(
        self,
        part: Part,
        found: list[ValueSet],
        overflowing: frozenset[int],
        first: int,
        place: int,
        values: ValueSet,
    ) -> dict[int, ValueSet]:
        """Return the domains of the cells of a term whose value is in a set.

        Args:
            part: The part with the term.
            found: Possible values of the terms of the part.
            overflowing: See `_united`.
            first: Position of the first subterm.
            place: Position of the term.
            values: The set.

        Raises:
            Empty: The term has no value in the set.
        """
        wanted = {place: meet(found[place], values)}
        sets: dict[int, ValueSet] = {}
        for current in range(place, first - 1, -1):
            node = part.nodes[current]
            here = wanted.get(current, found[current])
            if node.cell >= 0:
                sets[node.cell] = meet(sets.get(node.cell, self.sets[node.cell]), here)
            elif node.args and ((current in wanted and here != found[current]) or current in overflowing):
                args = [found[arg] for arg in node.args]
                for arg, narrowed in zip(node.args, backward(node.term, here, args, self.wrapping), strict=True):
                    wanted[arg] = meet(found[arg], narrowed)
        return sets

    def _compute(self, number: int, cell: int, definition: Term) -> list[tuple[int, ValueSet]]:
        """Compute a cell from its definition in a part, whose other cells are known."""
        others = [other for other in self.parts[number].cells if other != cell]
        try:
            value = evaluate(definition, self.values(others))
        except Unevaluable as reason:
            self.remarks[number] = str(reason)
            raise Empty from None
        before = self.sets[cell]
        if not contains(before, value):
            raise Empty
        self.narrow(cell, single(value), number, exact=all(self.exact[other] for other in others))
        return [(cell, before)]

    def _list(self, number: int, cell: int) -> list[tuple[int, ValueSet]]:
        """Remove invalid values of the only open cell of a part, if it has few values."""
        before = self.sets[cell]
        listed = members(before)
        if listed is None or len(listed) == 1:
            return []
        part = self.parts[number]
        self.effort += len(listed) * part.cost
        values = self.values(other for other in part.cells if other != cell)
        tolerance = self._tolerance(part)
        reasons: list[str] = []

        def fits(value: Value) -> bool:
            try:
                return evaluate(part.term, {**values, self.cells[cell]: value}, tolerance) is True
            except Unevaluable as reason:
                reasons.append(str(reason))
                return False

        try:
            kept = filtered(listed, fits)
        except Empty:
            if len(reasons) == len(listed):
                self.remarks[number] = reasons[0]
            raise
        if len(kept.values) == len(listed):
            return []
        self.narrow(cell, single(kept.values[0]) if len(kept.values) == 1 else kept, number)
        return [(cell, before)]


def _is_large_step(before: ValueSet, after: ValueSet) -> bool:
    """Return whether narrowing removed much of a range, or added a bound."""
    if not (isinstance(before, Range) and isinstance(after, Range)) or after.low == after.high:
        return True
    if math.isinf(before.low) > math.isinf(after.low) or math.isinf(before.high) > math.isinf(after.high):
        return True
    return after.high - after.low < LARGE_STEP * (before.high - before.low)
