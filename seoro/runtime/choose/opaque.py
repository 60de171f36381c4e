"""Expressions without terms: they are evaluated for values of the cells that they depend on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeAlias, cast

from seoro.lang import solve
from seoro.lang.plan import Binding, Call, Construct, Expression, Self, Structures, parts, walk
from seoro.lang.solve import terms
from seoro.lang.solve.evaluation import evaluate as evaluate_term
from seoro.runtime.choose.forms import TERMS, Symbolic, SymbolicList, SymbolicRange
from seoro.runtime.choose.slots import Slot, Slots
from seoro.runtime.values.environment import Deferred, Environment, Evaluate, EvaluationError
from seoro.runtime.values.values import HasFields, Range, Value

_Valuation: TypeAlias = Callable[[Mapping[solve.Cell, solve.Value]], solve.Value]

CHOICE_COST = 2000  # of an expression that chooses values itself, relative to a term


class Opaques:
    """Makes opaque terms from expressions.

    Args:
        slots: Slots of the choice; those of scalars have cells.
        evaluate: Evaluates expressions.
        put: Puts tentative values into the instances, for evaluation.
        open_slots: Slots whose definitions are being examined.
    """

    def __init__(
        self,
        slots: Slots,
        evaluate: Evaluate,
        put: Callable[[Mapping[solve.Cell, solve.Value]], None],
        open_slots: list[Slot],
    ) -> None:
        self._slots = slots
        self._evaluate = evaluate
        self._put = put
        self._open = open_slots

    def term(self, expression: Expression, environment: Environment) -> terms.Term:
        """Return the opaque term of an expression."""
        cells: dict[solve.Cell, None] = {}
        for slot in self._named(expression, environment):
            self._collect(slot, cells)

        def value(chosen: Mapping[solve.Cell, solve.Value]) -> solve.Value:
            self._put(chosen)
            try:
                return self._evaluate(expression, _concrete(environment, chosen))
            except EvaluationError as error:
                raise terms.Unevaluable(str(error)) from error

        on = tuple(cells)
        if _chooses(expression, environment.plan.structures):
            return terms.Opaque(on, _remembered(on, value), expression.span.text, CHOICE_COST)
        return terms.Opaque(on, value, expression.span.text, terms.OPAQUE_COST)

    def _named(self, expression: Expression, environment: Environment) -> list[Slot]:
        """Return the slots that an expression may read; all of its instance, if a method may read them."""
        found: list[Slot] = []
        pending = [expression]
        while pending:
            current = pending.pop()
            slot = self._slots.find(current, environment)
            if slot is not None:
                found.append(slot)
                continue
            match current:
                case Self() | Call(receiver=None):
                    found += self._slots.of(environment.instance).values()
                case Binding(name) if isinstance(bound := environment.bindings.get(name), Deferred):
                    found += self._named(bound.expression, bound.environment)
                case Binding(name) if name in environment.bindings:
                    found += self._bound(environment.bindings[name])
                case _:
                    pass
            pending += parts(current)
        return found

    def _bound(self, value: Symbolic) -> list[Slot]:
        """Return the slots of a bound value."""
        match value:
            case SymbolicList(items):
                return [slot for item in items for slot in self._bound(item)]
            case SymbolicRange(low, high):
                return [*self._bound(low), *self._bound(high)]
            case _ if isinstance(value, TERMS):
                return [self._slots.with_cell(cell) for cell in terms.cells_of(value)]
            case _:
                return list(self._slots.of(value).values())

    def _collect(self, slot: Slot, cells: dict[solve.Cell, None]) -> None:
        """Collect the cells on which the value of a slot depends."""
        if slot.is_given:
            return
        if slot.cell is not None:
            cells[slot.cell] = None
        elif slot.made is not None:
            for part in self._slots.of(slot.made).values():
                self._collect(part, cells)
        elif slot.definition is not None and slot not in self._open:
            assert slot.definition.value is not None
            self._open.append(slot)
            for named in self._named(slot.definition.value, slot.definition.environment):
                self._collect(named, cells)
            self._open.pop()
        for part in slot.parts.values():
            self._collect(part, cells)


def _remembered(cells: tuple[solve.Cell, ...], value: _Valuation) -> _Valuation:
    """Cache a valuation: a choice takes a millisecond, and a search makes thousands."""
    known: dict[tuple[solve.Value | None, ...], solve.Value | terms.Unevaluable] = {}

    def remembered(chosen: Mapping[solve.Cell, solve.Value]) -> solve.Value:
        key = tuple(chosen.get(cell) for cell in cells)
        if key not in known:
            try:
                known[key] = value(chosen)
            except terms.Unevaluable as error:
                known[key] = error
        found = known[key]
        if isinstance(found, terms.Unevaluable):
            raise terms.Unevaluable(str(found))
        return found

    return remembered


def _chooses(expression: Expression, structures: Structures) -> bool:
    """Whether evaluation of an expression chooses values of an instance."""
    made = (part.type for part in walk(expression) if isinstance(part, Construct))
    return not all(structures.of(type_).is_plain for type_ in made)


def _concrete(environment: Environment, chosen: Mapping[solve.Cell, solve.Value]) -> Environment:
    """Return the environment with values instead of symbolic bindings."""
    bindings = {name: _value(value, chosen) for name, value in environment.bindings.items()}
    return replace(environment, bindings=bindings)


def _value(value: Symbolic, chosen: Mapping[solve.Cell, solve.Value]) -> Value | HasFields:
    match value:
        case SymbolicList(items):
            return tuple(cast(Value, _value(item, chosen)) for item in items)
        case SymbolicRange(low, high):
            return Range(cast(float, _value(low, chosen)), cast(float, _value(high, chosen)))
        case _ if isinstance(value, TERMS):
            return cast(Value, evaluate_term(value, chosen))
        case _:
            return cast("Value | HasFields", value)
