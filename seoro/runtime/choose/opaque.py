"""Expressions that have no form in terms: they are evaluated for values of the cells that they depend on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeAlias, cast

from seoro.lang import solve
from seoro.lang.plan import Binding, Call, Construct, Expression, Self, parts
from seoro.lang.solve import terms
from seoro.lang.solve.evaluation import evaluate as evaluate_term
from seoro.runtime.choose.forms import TERMS, Symbolic, SymbolicList, SymbolicRange
from seoro.runtime.choose.slots import Slot, Slots
from seoro.runtime.environment import Deferred, Environment, Evaluate, EvaluationError
from seoro.runtime.values import HasFields, Range, Value

_Valuation: TypeAlias = Callable[[Mapping[solve.Cell, solve.Value]], solve.Value]

CHOICE_COST = 2000  # of an expression that chooses values itself, in terms


class Opaques:
    """Makes opaque terms of the expressions of one choice.

    Args:
        slots: The slots that get values; those of scalars have cells.
        evaluate: Evaluates expressions of which everything is known.
        put: Puts tentative values into the instances, for what is evaluated.
        open_slots: Slots whose definitions are being looked into, now.
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
        """An expression as a term that is opaque."""
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
        if _chooses(expression):
            return terms.Opaque(on, _remembered(on, value), expression.span.text, CHOICE_COST)
        return terms.Opaque(on, value, expression.span.text, terms.OPAQUE_COST)

    def _named(self, expression: Expression, environment: Environment) -> list[Slot]:
        """The slots that an expression may look at; of its own instance, all, if a method may."""
        found: list[Slot] = []
        pending = [expression]
        while pending:
            current = pending.pop()
            slot = self._slots.find(current, environment)
            if slot is not None:
                found.append(slot)
                continue
            match current:
                case Self():
                    found += self._slots.of(environment.instance).values()
                case Call(receiver=None):
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
        """The slots that the value of a binding is about."""
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
        """The cells on which the value of a slot depends."""
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
    """The same, which asks for no value twice: a choice takes a millisecond, and a search makes thousands."""
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


def _chooses(expression: Expression) -> bool:
    """Whether values of an instance have to be chosen to evaluate an expression."""
    pending = [expression]
    while pending:
        current = pending.pop()
        if isinstance(current, Construct) and not current.structures.of(current.type).is_plain:
            return True
        pending += parts(current)
    return False


def _concrete(environment: Environment, chosen: Mapping[solve.Cell, solve.Value]) -> Environment:
    """The environment with values in the place of what is symbolic among its bindings."""
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
