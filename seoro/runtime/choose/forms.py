"""Symbolic values: values that depend on unchosen ones, decomposed until only scalars are terms.

Chains of operators (`a + b + c`, `a and b and c` and the like) may be long, so they are terms of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias, cast, get_args

from seoro.lang import frozen, solve
from seoro.lang.arithmetic import Number
from seoro.lang.plan import Arithmetic, Bulk, Compare, Concatenate, Expression, Index, Literal, Logic
from seoro.lang.solve import terms
from seoro.runtime.values.conversions import to_number
from seoro.runtime.values.environment import EvaluationError
from seoro.runtime.values.values import Actor, HasFields, Range, Struct, Value


class SymbolicList(frozen.Value):
    """A list with unknown members."""

    items: tuple[Symbolic, ...]


class SymbolicRange(frozen.Value):
    """A range with an unknown bound; the lower bound comes first."""

    low: Symbolic
    high: Symbolic


Symbolic: TypeAlias = "Value | HasFields | SymbolicList | SymbolicRange | terms.Term"
TERMS = get_args(terms.Term)
UNKNOWN = (*TERMS, SymbolicList, SymbolicRange)


class NotSymbolic(Exception):
    """An expression has no term."""


class NotYet(Exception):
    """An expression names a field that a value has only as a conditional subtype."""


def as_term(value: Symbolic) -> terms.Term:
    """Return a scalar as a term.

    Raises:
        NotSymbolic: It has no term.
    """
    if isinstance(value, TERMS):
        return cast(terms.Term, value)
    if isinstance(value, SymbolicList | SymbolicRange):
        raise NotSymbolic
    return terms.Const(cast(solve.Value, value))


def listed(items: tuple[Symbolic, ...]) -> Symbolic:
    """Return a list, symbolic if a member is."""
    if any(isinstance(item, UNKNOWN) for item in items):
        return SymbolicList(items)
    return cast("tuple[Value, ...]", items)


def items_of(value: Symbolic) -> tuple[Symbolic, ...]:
    """Return the members of a list.

    Raises:
        NotSymbolic: They are unknown.
    """
    if isinstance(value, SymbolicList):
        return value.items
    if isinstance(value, tuple):
        return value
    raise NotSymbolic


def ordered_range(first: terms.Term, second: terms.Term) -> SymbolicRange:
    """Return the range between two bounds in any order (7.4.2.8.1)."""
    is_ascending = terms.Compare("<=", first, second)
    low = terms.IfThenElse(is_ascending, first, second)
    return SymbolicRange(low, terms.IfThenElse(is_ascending, second, first))


def converted(value: Symbolic, number: Number) -> Symbolic:
    """Convert a number, or each part of a list or a range; bounds that wrap may swap."""
    match value:
        case SymbolicList(items):
            return SymbolicList(tuple(converted(item, number) for item in items))
        case SymbolicRange(low, high):
            first, second = converted(low, number), converted(high, number)
            if number is Number.FLOAT:
                return SymbolicRange(first, second)
            return ordered_range(as_term(first), as_term(second))
        case _ if isinstance(value, TERMS):
            return terms.ToReal(value) if number is Number.FLOAT else terms.ToWhole(value, number)
        case _:
            return to_number(cast(Value, value), number)


def any_of(conditions: list[terms.Term]) -> Symbolic:
    """Return the disjunction of conditions."""
    return terms.Or(tuple(conditions)) if conditions else False


def all_of(conditions: list[terms.Term]) -> terms.Term:
    """Return the conjunction of conditions."""
    return terms.And(tuple(conditions)) if len(conditions) != 1 else conditions[0]


def count_of(conditions: list[terms.Term]) -> terms.Term:
    """Return the number of true conditions."""
    total: terms.Term = terms.Const(0)
    for condition in conditions:
        one = terms.IfThenElse(condition, terms.Const(1), terms.Const(0))
        total = terms.Arithmetic("+", total, one, Number.INT)
    return total


def bounds_of(value: Symbolic) -> tuple[Symbolic, Symbolic] | None:
    """Return the bounds of a range; None for other values."""
    match value:
        case SymbolicRange(low, high):
            return low, high
        case Range(lower, upper):
            return lower, upper
        case _:
            return None


def same(left: Symbolic, right: Symbolic) -> terms.Term:
    """Return the equality of two values: identity of structs and actors (7.4.2.4.2), parts of others."""
    ranges = bounds_of(left), bounds_of(right)
    if ranges[0] is not None and ranges[1] is not None:
        (low, high), (lower, upper) = ranges[0], ranges[1]
        return all_of([same(low, lower), same(high, upper)])
    if isinstance(left, SymbolicList) or isinstance(right, SymbolicList):
        one, other = items_of(left), items_of(right)
        if len(one) != len(other):
            return terms.Const(False)
        return all_of([same(first, second) for first, second in zip(one, other, strict=True)])
    if isinstance(left, Struct | Actor) and isinstance(right, Struct | Actor):
        return terms.Const(left is right)
    return terms.Compare("==", as_term(left), as_term(right))


def contains(item: Symbolic, container: Symbolic) -> Symbolic:
    """Return the containment of a value, or of all of a range or a list (7.4.2.4.1)."""
    bounds = bounds_of(container)
    if bounds is not None:
        low, high = as_term(bounds[0]), as_term(bounds[1])
        inner = bounds_of(item)
        items = list(inner) if inner is not None else [item]
        return all_of([terms.InRange(as_term(each), low, high) for each in items])
    members = items_of(container)
    if isinstance(item, SymbolicList | tuple):
        return all_of([as_term(contains(each, container)) for each in items_of(item)])
    if any(isinstance(member, UNKNOWN) for member in members) or isinstance(item, Struct | Actor):
        return any_of([same(item, member) for member in members])
    return terms.InSet(as_term(item), cast("tuple[solve.Value, ...]", members))


def with_operands(expression: Expression, found: list[Symbolic]) -> Expression:
    """Return an operation with values as operands."""
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


Operation = Arithmetic | Concatenate | Compare | Logic


def joined(operation: Operation) -> object:
    """Return a key that is equal for adjacent operators translated together: `and`, `or`, `+` of strings."""
    match operation:
        case Logic("and" | "or" as operator):
            return operator
        case Concatenate():
            return Concatenate
        case _:
            return id(operation)


def operated(operation: Operation, left: Symbolic, right: Symbolic) -> terms.Term:
    """Return the term of an operation with an unknown operand.

    Raises:
        NotSymbolic: It has no term.
    """
    match operation:
        case Arithmetic(operator, number=number):
            kind = cast(terms.Operation, operator)
            return terms.Arithmetic(kind, as_term(left), as_term(right), number)
        case Compare("=="):
            return same(left, right)
        case Compare("!="):
            return terms.Not(same(left, right))
        case Compare(operator):
            return terms.Compare(cast(terms.Relation, operator), as_term(left), as_term(right))
        case _:
            raise NotSymbolic


def junction(operator: str, members: list[Symbolic]) -> Symbolic:
    """Return the term of `and` or `or`; all members but the last are unknown."""
    if len(members) == 1:
        return members[0]
    if not members:
        return operator == "and"
    whole = tuple(as_term(member) for member in members)
    return terms.Or(whole) if operator == "or" else terms.And(whole)


def member(items: tuple[Symbolic, ...], position: Symbolic, expression: Index) -> Symbolic:
    """Return a member of a list.

    Raises:
        NotSymbolic: The position is unknown.
        EvaluationError: It is outside the list.
    """
    if not isinstance(position, int):
        raise NotSymbolic
    if not 0 <= position < len(items):
        raise EvaluationError(f"index {position} is outside of a list of {len(items)}", expression.span)
    return items[position]


def gathered(operator: Bulk, items: tuple[Symbolic, ...], results: Sequence[Symbolic]) -> Symbolic:
    """Return the result of a list method from the results for its members.

    Raises:
        NotSymbolic: It depends on unknown results.
    """
    match operator:
        case Bulk.MAP:
            return listed(tuple(results))
        case Bulk.HAS:
            return any_of([as_term(result) for result in results])
        case Bulk.COUNT:
            return count_of([as_term(result) for result in results])
        case Bulk.FILTER if all(isinstance(result, bool) for result in results):
            return listed(tuple(item for item, result in zip(items, results, strict=True) if result))
        case Bulk.FIRST_INDEX if all(isinstance(result, bool) for result in results):
            return results.index(True) if True in results else -1
        case _:
            raise NotSymbolic
