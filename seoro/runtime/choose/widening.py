"""Widening of the windows of times, as far as constraints allow.

All other values are drawn first and stay, except those defined by a time, which follow it. From the drawn times,
bounds are moved until the constraints end, to the nanosecond.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Final, cast

from seoro.lang import solve
from seoro.lang.plan import Overlap
from seoro.lang.solve import terms
from seoro.lang.solve.evaluation import TOLERANCE, evaluate, holds
from seoro.lang.source import Span
from seoro.runtime.choose.slots import Slot
from seoro.runtime.instances.times import DURATION, FOREVER, OVERLAP, START_TO_START, Times, Window, kind_value
from seoro.runtime.values.values import Range

_PER_SECOND: Final = 1_000_000_000  # times are kept to the nanosecond

Values = Mapping[solve.Cell, solve.Value]


class Widening:
    """Windows of times, for given values of all cells.

    Args:
        constraints: Constraints, each with whether it was written by the user.
        values: Values of all cells that meet them.
    """

    def __init__(self, constraints: Mapping[solve.Constraint, bool], values: Values) -> None:
        self._constraints = [(each, frozenset(terms.cells_of(each.term))) for each in constraints]
        self._written = constraints
        self.values = dict(values)
        is_exact = all(holds(each.term, values) for each, _ in self._constraints)
        self._tolerance = 0.0 if is_exact else TOLERANCE

    def widen(self, times: Times, slots: Mapping[str, Slot]) -> dict[str, Window]:
        """Return the windows of constrained times; `values` change with them."""
        found: dict[str, Window] = {}
        for name in times.names:
            slot, given = slots[name], times.given.get(name)
            own = given[1] if given is not None else None
            if slot.definition is not None:
                continue  # fully determined
            if name == DURATION:
                cells = tuple(slot.parts[key].cell for key in ("lower", "upper"))
                low, high = cast("tuple[solve.Cell, solve.Cell]", cells)
            else:
                low = high = cast(solve.Cell, slot.cell)
            if given is None and not self._about((low, high)):
                self._leave_open(name, low, high)
            elif name == DURATION:
                found[name] = self._widen_duration(low, high, given and given[0], own or times.span)
            else:
                found[name] = self._widen_offset(low, given is not None, own or times.span)
        if START_TO_START in found and times.overlap is not None and not times.is_overlap_given:
            self._let_overlap(times, cast(solve.Cell, slots[OVERLAP].cell))
        return found

    def _let_overlap(self, times: Times, kind: solve.Cell) -> None:
        """Allow any kind of overlap if only offsets of starts are given."""
        if not any(each.span != times.span and kind in used for each, used in self._constraints):
            self.values[kind] = kind_value(Overlap.ANY)

    def _about(self, cells: tuple[solve.Cell, solve.Cell]) -> bool:
        """Whether a written constraint affects a time."""
        return any(self._written[each] and not used.isdisjoint(cells) for each, used in self._constraints)

    def _leave_open(self, name: str, low: solve.Cell, high: solve.Cell) -> None:
        self.values |= {low: 0.0, high: inf if name == DURATION else 0.0}

    def _widen_duration(self, low: solve.Cell, high: solve.Cell, given: Range | None, span: Span) -> Window:
        least, most = (given.low, given.high) if given is not None else (0.0, FOREVER)
        self._stretch(low, least)
        self._stretch(high, most)
        lower, upper = cast(float, self.values[low]), cast(float, self.values[high])
        culprit = self._refusing({high: upper + 1 / _PER_SECOND})
        if upper >= FOREVER:
            self.values[high] = upper = inf
        if culprit is None or culprit.span == span:
            return Window(Range(lower, upper), span)
        return Window(Range(lower, upper), culprit.span, culprit.text)

    def _widen_offset(self, cell: solve.Cell, is_given: bool, span: Span) -> Window:
        if not is_given:
            self._stretch(cell, 0.0)  # no delay without need
        value = cast(float, self.values[cell])
        bounds: list[float] = []
        for limit in (-FOREVER, FOREVER):
            self._stretch(cell, limit)
            bound = cast(float, self.values[cell])
            bounds.append(bound if abs(bound) < FOREVER else bound * inf)
            self.values |= self._following({cell: value})
        culprit = self._refusing({cell: max(bounds) + 1 / _PER_SECOND})
        own = Widening(self._written, self.values)
        return Window(
            Range(min(bounds), max(bounds)),
            culprit.span if culprit is not None else span,
            culprit.text if culprit is not None and culprit.span != span else "",
            value,
            lambda time: own._refusing({cell: time}) is None,
        )

    # -------------------------------------------------------- one bound

    def _stretch(self, cell: solve.Cell, limit: float) -> None:
        """Move a cell as close to a limit as constraints allow, to the nanosecond."""
        if self._refusing({cell: limit}) is None:
            self.values |= self._following({cell: limit})
            return
        value = cast(float, self.values[cell])
        last = round(limit * _PER_SECOND)
        first = round(value * _PER_SECOND)
        first += 0 if self._refusing({cell: first / _PER_SECOND}) is None else 1 if last > first else -1
        if self._refusing({cell: first / _PER_SECOND}) is not None:
            return
        while abs(last - first) > 1:
            middle = (first + last) // 2
            if self._refusing({cell: middle / _PER_SECOND}) is None:
                first = middle
            else:
                last = middle
        self.values |= self._following({cell: first / _PER_SECOND})

    def _following(self, changes: dict[solve.Cell, solve.Value]) -> dict[solve.Cell, solve.Value]:
        """Return changes including those of cells that are defined by changed ones."""
        found = dict(changes)
        pending = list(changes)
        while pending:
            changed = pending.pop()
            for constraint, used in self._constraints:
                match constraint.term:
                    case terms.Compare("==", terms.CellRef(cell), value) if changed in used and cell not in found:
                        found[cell] = evaluate(value, {**self.values, **found})
                        pending.append(cell)
                    case _:
                        pass
        return found

    def _refusing(self, changes: dict[solve.Cell, solve.Value]) -> solve.Constraint | None:
        """Return the first constraint that changes violate, or None."""
        try:
            following = self._following(changes)
        except terms.Unevaluable:
            return self._constraints[0][0]
        values = {**self.values, **following}
        for constraint, used in self._constraints:
            if not used.isdisjoint(following) and not holds(constraint.term, values, self._tolerance):
                return constraint
        return None
