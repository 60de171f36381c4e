"""Expressions of the plan as terms of the solver, where they depend on values that are not chosen yet.

What is known already is computed; structs, lists and ranges are taken apart, so that terms are about scalars only.
What has no such form becomes an opaque term, evaluated like any expression once all that it names is known.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias, cast, get_args

from seoro.lang import solve
from seoro.lang.plan import (
    Arithmetic,
    Binding,
    Bound,
    Bulk,
    Call,
    Compare,
    Conditional,
    Contains,
    Convert,
    Expression,
    External,
    Field,
    ForEach,
    Global,
    Index,
    Join,
    ListOf,
    Literal,
    Logic,
    Member,
    Negate,
    Not,
    Number,
    RangeOf,
    Self,
    Side,
    Size,
    TypeTest,
    Undefined,
    parts,
)
from seoro.lang.solve import terms
from seoro.lang.solve.evaluation import evaluate as evaluate_term
from seoro.runtime.choose.slots import Slot, Slots
from seoro.runtime.environment import Environment, Evaluate, EvaluationError
from seoro.runtime.methods import MAX_DEPTH, implementation, inside
from seoro.runtime.values import Actor, HasFields, Range, Struct, Value


@dataclass(frozen=True)
class SymbolicList:
    """A list of which some members are not known."""

    items: tuple[Symbolic, ...]


@dataclass(frozen=True)
class SymbolicRange:
    """A range of which a bound is not known; the lower one comes first."""

    low: Symbolic
    high: Symbolic


Symbolic: TypeAlias = "Value | HasFields | SymbolicList | SymbolicRange | terms.Term"
_TERMS = get_args(terms.Term)
_UNKNOWN = (*_TERMS, SymbolicList, SymbolicRange)
_NUMBERS: Mapping[Number, terms.Number] = {number: terms.Number(number.value) for number in Number}


class NotSymbolic(Exception):
    """An expression has no form as a term."""


class NotYet(Exception):
    """An expression names a field that a value has only if it turns out to be of a conditional subtype."""


class Translation:
    """Translates the expressions of one choice.

    Args:
        slots: The slots that get values; those of scalars have cells.
        evaluate: Evaluates expressions of which everything is known.
        put: Puts tentative values into the instances, for what is evaluated.
    """

    def __init__(
        self, slots: Slots, evaluate: Evaluate, put: Callable[[Mapping[solve.Cell, solve.Value]], None]
    ) -> None:
        self._slots = slots
        self._evaluate = evaluate
        self._put = put
        self._open: list[Slot] = []

    def condition(self, expression: Expression, environment: Environment) -> terms.Term:
        """A condition as a term.

        Raises:
            NotYet: It is about a subtype that a value may not be of.
        """
        return _term(self._symbolic(expression, environment))

    def equality(self, slot: Slot, expression: Expression, environment: Environment) -> terms.Term:
        """That a slot holds the value of an expression, as a term."""
        return _same(self._of_slot(slot), self._symbolic(expression, environment))

    # ------------------------------------------------------------ names

    def _field(self, holder: Symbolic, name: str) -> Symbolic:
        slot = self._slots.of(holder).get(name)
        if slot is not None:
            return self._of_slot(slot)
        if isinstance(holder, _UNKNOWN):
            raise NotSymbolic
        if name not in cast(HasFields, holder).fields:
            raise NotYet(name)
        return cast(HasFields, holder).fields[name]

    def _of_slot(self, slot: Slot) -> Symbolic:
        if slot.is_given:
            return slot.holder.fields[slot.key]
        if slot.cell is not None:
            return terms.CellRef(slot.cell)
        if slot.made is not None:
            return slot.made
        if slot.definition is not None:
            return self._definition(slot)
        if slot.size is not None:
            raise NotYet(slot.path)
        if "lower" in slot.parts:
            return SymbolicRange(self._of_slot(slot.parts["lower"]), self._of_slot(slot.parts["upper"]))
        return SymbolicList(tuple(self._of_slot(part) for part in slot.parts.values()))

    def _definition(self, slot: Slot) -> Symbolic:
        rule = slot.definition
        assert rule is not None and rule.value is not None
        if slot in self._open:
            raise EvaluationError(f"the value of `{slot.path}` depends on itself", slot.span)
        self._open.append(slot)
        try:
            return self._symbolic(rule.value, rule.environment)
        finally:
            self._open.pop()

    # ------------------------------------------------------------ expressions

    def _symbolic(self, expression: Expression, environment: Environment) -> Symbolic:
        if environment.depth > MAX_DEPTH:
            raise EvaluationError(f"methods call each other more than {MAX_DEPTH} deep", expression.span)
        try:
            return self._form(expression, environment)
        except NotSymbolic:
            return self._opaque(expression, environment)

    def _form(self, expression: Expression, environment: Environment) -> Symbolic:
        match expression:
            case Literal(value):
                return value
            case Field(name):
                return self._field(environment.instance, name)
            case Global(name):
                return self._field(environment.outermost, name)
            case Self():
                return environment.instance
            case Binding(name):
                return environment.bindings[name]
            case Member(base, name):
                return self._field(self._symbolic(base, environment), name)
            case Call():
                return self._call(expression, environment)
            case Logic() | Not() | Conditional() | Compare() | Contains() | TypeTest():
                return self._truth(expression, environment)
            case ListOf(items):
                return _listed(tuple(self._symbolic(item, environment) for item in items))
            case ForEach():
                return self._for_each(expression, environment)
            case _:
                return self._operation(expression, environment)

    def _operation(self, expression: Expression, environment: Environment) -> Symbolic:
        """What is computed from other values, in terms of them or, if they are all known, at once."""
        if isinstance(expression, Size) and (size := self._size(expression, environment)) is not None:
            return size
        found = [self._symbolic(part, environment) for part in parts(expression)]
        if not any(isinstance(value, _UNKNOWN) for value in found):
            return self._evaluate(_with_operands(expression, found), environment)
        match expression, found:
            case Negate(number=number), [operand]:
                return terms.Negate(_term(operand), _NUMBERS[number])
            case Arithmetic(operator, number=number), [left, right]:
                operation = cast(terms.Operation, operator)
                return terms.Arithmetic(operation, _term(left), _term(right), _NUMBERS[number])
            case Convert(), [operand]:
                return _to_real(operand)
            case RangeOf(), [low, high]:
                return _ordered(_term(low), _term(high))
            case Bound(side), [SymbolicRange(low, high)]:
                return low if side is Side.LOWER else high
            case Size(), [items]:
                return len(_items(items))
            case Index(), [items, position]:
                return self._member(_items(items), position, expression)
            case Join(), lists:
                return _listed(tuple(item for each in lists for item in _items(each)))
            case _:
                raise NotSymbolic

    def _size(self, expression: Size, environment: Environment) -> Symbolic | None:
        """The size of a list that is made here and has none yet."""
        slot = self._slots.find(expression.items, environment)
        return terms.CellRef(slot.size) if slot is not None and slot.size is not None else None

    def _member(self, items: tuple[Symbolic, ...], position: Symbolic, expression: Index) -> Symbolic:
        if not isinstance(position, int):
            raise NotSymbolic
        if not 0 <= position < len(items):
            raise EvaluationError(f"index {position} is outside of a list of {len(items)}", expression.span)
        return items[position]

    def _for_each(self, expression: ForEach, environment: Environment) -> Symbolic:
        items = _items(self._symbolic(expression.items, environment))
        results: list[Symbolic] = []
        for item in items:
            within = replace(environment, bindings={**environment.bindings, "it": cast(Value, item)})
            results.append(self._symbolic(expression.body, within))
        match expression.operator:
            case Bulk.MAP:
                return _listed(tuple(results))
            case Bulk.HAS:
                return _any([_term(result) for result in results])
            case Bulk.COUNT:
                return _count([_term(result) for result in results])
            case Bulk.FILTER if all(isinstance(result, bool) for result in results):
                return _listed(tuple(item for item, result in zip(items, results, strict=True) if result))
            case Bulk.FIRST_INDEX if all(isinstance(result, bool) for result in results):
                return results.index(True) if True in results else -1
            case _:
                raise NotSymbolic

    def _call(self, expression: Call, environment: Environment) -> Symbolic:
        """A method with an expression is put in the place of its call; any other waits for its arguments."""
        receiver = expression.receiver
        holder = self._symbolic(receiver, environment) if receiver is not None else environment.instance
        if isinstance(holder, _UNKNOWN):
            raise NotSymbolic
        holder = cast("Value | HasFields", holder)
        method = implementation(expression, holder)
        if isinstance(method.body, External | Undefined):
            raise NotSymbolic
        given = {name: self._symbolic(value, environment) for name, value in expression.arguments}
        within = inside(expression, holder, environment)
        bindings = dict(within.bindings)
        within = replace(within, bindings=bindings)
        for name, default in method.parameters:
            if name not in given:
                assert default is not None, "checked: it has a value or a default"
                given[name] = self._symbolic(default, within)
            bindings[name] = cast(Value, given[name])
        return self._symbolic(method.body, within)

    # ------------------------------------------------------------ truth

    def _truth(self, expression: Expression, environment: Environment) -> Symbolic:
        match expression:
            case Logic(operator, left, right):
                return self._logic(operator, left, right, environment)
            case Not(operand):
                truth = self._symbolic(operand, environment)
                return terms.Not(_term(truth)) if isinstance(truth, _UNKNOWN) else not truth
            case Conditional(condition, then, otherwise):
                return self._conditional(condition, then, otherwise, environment)
            case Compare() | Contains():
                one, other = (self._symbolic(part, environment) for part in parts(expression))
                if not isinstance(one, _UNKNOWN) and not isinstance(other, _UNKNOWN):
                    return self._evaluate(_with_operands(expression, [one, other]), environment)
                if isinstance(expression, Contains):
                    return _contains(one, other)
                return _compare(expression.operator, one, other)
            case TypeTest(operand):
                return self._type_test(expression, self._symbolic(operand, environment), environment)
            case _:
                raise AssertionError("not a truth")

    def _logic(self, operator: str, left: Expression, right: Expression, environment: Environment) -> Symbolic:
        first = self._symbolic(left, environment)
        if isinstance(first, bool):
            if first == (operator == "or"):
                return first
            if operator == "=>" and not first:
                return True
            return self._symbolic(right, environment)
        both = _term(first), _term(self._symbolic(right, environment))
        match operator:
            case "and":
                return terms.And(both)
            case "or":
                return terms.Or(both)
            case _:
                return terms.Implies(*both)

    def _conditional(
        self, condition: Expression, then: Expression, otherwise: Expression, environment: Environment
    ) -> Symbolic:
        truth = self._symbolic(condition, environment)
        if isinstance(truth, bool):
            return self._symbolic(then if truth else otherwise, environment)
        first, second = self._symbolic(then, environment), self._symbolic(otherwise, environment)
        return terms.IfThenElse(_term(truth), _term(first), _term(second))

    def _type_test(self, expression: TypeTest, operand: Symbolic, environment: Environment) -> Symbolic:
        """A value that is made here is of a conditional subtype if the fields that decide say so."""
        name = getattr(expression.type, "name", None)
        if isinstance(operand, Struct | Actor):
            slots = self._slots.of(operand)
            slot = self._slots.holding(operand)
            if slots and slot is not None and name not in operand.types and slot.structure is not None:
                latents = {latent.type: latent for latent in slot.structure.latents}
                conditions: list[terms.Term] = []
                while name in latents and name not in operand.types:
                    latent = latents[name]
                    conditions.append(_same(self._field(operand, latent.field), latent.value))
                    name = latent.base
                if conditions and name in operand.types:
                    return terms.And(tuple(conditions))
        if isinstance(operand, _UNKNOWN):
            raise NotSymbolic
        return self._evaluate(_with_operands(expression, [operand]), environment)

    # ------------------------------------------------------------ what is opaque

    def _opaque(self, expression: Expression, environment: Environment) -> terms.Term:
        cells: dict[solve.Cell, None] = {}
        for slot in self._named(expression, environment):
            self._collect(slot, cells)

        def value(chosen: Mapping[solve.Cell, solve.Value]) -> solve.Value:
            self._put(chosen)
            try:
                return self._evaluate(expression, _concrete(environment, chosen))
            except EvaluationError as error:
                raise terms.Unevaluable(str(error)) from error

        return terms.Opaque(tuple(cells), value, expression.span.text)

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
            case _ if isinstance(value, _TERMS):
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


# ---------------------------------------------------------------- symbolic values


def _term(value: Symbolic) -> terms.Term:
    if isinstance(value, _TERMS):
        return cast(terms.Term, value)
    if isinstance(value, SymbolicList | SymbolicRange):
        raise NotSymbolic
    return terms.Const(cast(solve.Value, value))


def _listed(items: tuple[Symbolic, ...]) -> Symbolic:
    if any(isinstance(item, _UNKNOWN) for item in items):
        return SymbolicList(items)
    return cast("tuple[Value, ...]", items)


def _items(value: Symbolic) -> tuple[Symbolic, ...]:
    if isinstance(value, SymbolicList):
        return value.items
    if isinstance(value, tuple):
        return value
    raise NotSymbolic


def _ordered(first: terms.Term, second: terms.Term) -> SymbolicRange:
    """A range between two bounds, which may come in any order (7.4.2.8.1)."""
    is_ascending = terms.Compare("<=", first, second)
    low = terms.IfThenElse(is_ascending, first, second)
    return SymbolicRange(low, terms.IfThenElse(is_ascending, second, first))


def _to_real(value: Symbolic) -> Symbolic:
    match value:
        case SymbolicList(items):
            return SymbolicList(tuple(_to_real(item) for item in items))
        case SymbolicRange(low, high):
            return SymbolicRange(_to_real(low), _to_real(high))
        case int():
            return float(value)
        case _ if isinstance(value, _TERMS):
            return terms.ToReal(value)
        case _:
            return value


def _any(conditions: list[terms.Term]) -> Symbolic:
    return terms.Or(tuple(conditions)) if conditions else False


def _all(conditions: list[terms.Term]) -> terms.Term:
    return terms.And(tuple(conditions)) if len(conditions) != 1 else conditions[0]


def _count(conditions: list[terms.Term]) -> terms.Term:
    total: terms.Term = terms.Const(0)
    for condition in conditions:
        one = terms.IfThenElse(condition, terms.Const(1), terms.Const(0))
        total = terms.Arithmetic("+", total, one, terms.Number.INT)
    return total


def _bounds(value: Symbolic) -> tuple[Symbolic, Symbolic] | None:
    match value:
        case SymbolicRange(low, high):
            return low, high
        case Range(lower, upper):
            return lower, upper
        case _:
            return None


def _same(left: Symbolic, right: Symbolic) -> terms.Term:
    """That two values are equal: structs and actors if they are the same one (7.4.2.4.2), others part by part."""
    ranges = _bounds(left), _bounds(right)
    if ranges[0] is not None and ranges[1] is not None:
        (low, high), (lower, upper) = ranges[0], ranges[1]
        return _all([_same(low, lower), _same(high, upper)])
    if isinstance(left, SymbolicList) or isinstance(right, SymbolicList):
        one, other = _items(left), _items(right)
        if len(one) != len(other):
            return terms.Const(False)
        return _all([_same(first, second) for first, second in zip(one, other, strict=True)])
    if isinstance(left, Struct | Actor) and isinstance(right, Struct | Actor):
        return terms.Const(left is right)
    return terms.Compare("==", _term(left), _term(right))


def _compare(operator: str, left: Symbolic, right: Symbolic) -> terms.Term:
    if operator in {"==", "!="}:
        equal = _same(left, right)
        return equal if operator == "==" else terms.Not(equal)
    return terms.Compare(cast(terms.Relation, operator), _term(left), _term(right))


def _contains(item: Symbolic, container: Symbolic) -> Symbolic:
    bounds = _bounds(container)
    if bounds is not None:
        low, high = _term(bounds[0]), _term(bounds[1])
        inner = _bounds(item)
        items = list(inner) if inner is not None else [item]
        return _all([terms.InRange(_term(each), low, high) for each in items])
    members = _items(container)
    if isinstance(item, SymbolicList | tuple):
        return _all([_term(_contains(each, container)) for each in _items(item)])
    if any(isinstance(member, _UNKNOWN) for member in members) or isinstance(item, Struct | Actor):
        return _any([_same(item, member) for member in members])
    return terms.InSet(_term(item), cast("tuple[solve.Value, ...]", members))


# ---------------------------------------------------------------- operands


def _with_operands(expression: Expression, found: list[Symbolic]) -> Expression:
    """An operation on values in the place of its operands."""
    values = iter(found)
    changes: dict[str, object] = {}
    for name in expression.__match_args__:
        value = getattr(expression, name)
        if isinstance(value, Expression):
            changes[name] = _literal(next(values), value)
        elif isinstance(value, tuple):
            changes[name] = tuple(
                _literal(next(values), item)
                if isinstance(item, Expression)
                else (item[0], _literal(next(values), item[1]))
                for item in value
            )
    return replace(expression, **changes)  # type: ignore[arg-type]


def _literal(value: Symbolic, operand: Expression) -> Literal:
    return Literal(cast(bool, value), operand.span)


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
        case _ if isinstance(value, _TERMS):
            return cast(Value, evaluate_term(value, chosen))
        case _:
            return cast("Value | HasFields", value)
