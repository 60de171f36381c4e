"""Evaluation of the plan's expressions.

Integers are 64 bit and wrap, `int / int` truncates toward zero and `%` takes the sign of the dividend; floats
follow IEEE 754, division by zero included (7.4.2.3, 7.3.2).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol, assert_never, cast

from seoro.lang.plan import (
    ActorType,
    Arithmetic,
    Binding,
    Compare,
    Concatenate,
    Conditional,
    Construct,
    Contains,
    Convert,
    Expression,
    Field,
    Index,
    ListOf,
    Literal,
    Logic,
    Member,
    Negate,
    Not,
    Number,
    RangeOf,
)
from seoro.lang.source import Span
from seoro.runtime.values import Actor, Range, Struct, Value, wrap_int, wrap_uint


class EvaluationError(Exception):
    """An expression has no value, such as a division of integers by zero."""

    def __init__(self, message: str, span: Span) -> None:
        super().__init__(message)
        self.span = span


class HasFields(Protocol):
    """Anything with fields by name: structs, actors, instances of scenarios, event objects."""

    @property
    def fields(self) -> Mapping[str, Value]:
        """Values by name."""
        ...


@dataclass(frozen=True)
class Environment:
    """What names in an expression stand for.

    Args:
        instance: Whose fields they are.
        bindings: `actor`, and what an `as` clause binds.
        path: Where a value that is constructed will be held; names actors.
    """

    instance: HasFields
    bindings: Mapping[str, Value | HasFields] = field(default_factory=dict)
    path: str = ""


def evaluate(expression: Expression, environment: Environment) -> Value:
    """The value of an expression.

    Raises:
        EvaluationError: It has none.
    """
    match expression:
        case Literal(value):
            return value
        case Field(name):
            return environment.instance.fields[name]
        case Binding(name):
            # An event object is no value of the language, but it is only ever looked into, by Member.
            return cast(Value, environment.bindings[name])
        case Member(base, name):
            holder = evaluate(base, environment)
            return holder.fields[name]  # type: ignore[union-attr] # checked: it has fields
        case Conditional(condition, then, otherwise):
            return evaluate(then if evaluate(condition, environment) else otherwise, environment)
        case ListOf(items):
            return tuple(evaluate(item, environment) for item in items)
        case RangeOf(low, high):
            return Range(_number(low, environment), _number(high, environment))
        case Index():
            return _index(expression, environment)
        case Convert(operand):
            return _to_float(evaluate(operand, environment))
        case Construct():
            return _construct(expression, environment)
        case _:
            return _operate(expression, environment)


def _operate(expression: Expression, environment: Environment) -> Value:
    match expression:
        case Negate(operand, number, span):
            return _finish(-_number(operand, environment), number)
        case Arithmetic(operator, left, right, number, span):
            return _calculate(operator, _number(left, environment), _number(right, environment), number, span)
        case Concatenate(left, right):
            return f"{evaluate(left, environment)}{evaluate(right, environment)}"
        case Compare(operator, left, right):
            return _COMPARISONS[operator](evaluate(left, environment), evaluate(right, environment))
        case Contains(item, container):
            return _contains(evaluate(item, environment), evaluate(container, environment))
        case Not(operand):
            return not evaluate(operand, environment)
        case Logic(operator, left, right):
            return _logic(operator, left, right, environment)
        case (
            Literal() | Field() | Binding() | Member() | Conditional() | ListOf() | RangeOf() | Index()
            | Convert() | Construct()
        ):  # fmt: skip
            raise AssertionError("evaluated above")
        case _:
            assert_never(expression)


def _number(expression: Expression, environment: Environment) -> int | float:
    value = evaluate(expression, environment)
    assert isinstance(value, int | float)
    return value


def _to_float(value: Value) -> Value:
    """A number as a float; of a list or a range, each element."""
    match value:
        case tuple():
            return tuple(map(_to_float, value))
        case Range(low, high):
            return Range(float(low), float(high))
        case _:
            assert isinstance(value, int | float)
            return float(value)


def _finish(value: int | float, number: Number) -> int | float:
    match number:
        case Number.INT:
            return wrap_int(int(value))
        case Number.UINT:
            return wrap_uint(int(value))
        case Number.FLOAT:
            return float(value)
        case _:
            assert_never(number)


def _calculate(operator: str, left: int | float, right: int | float, number: Number, span: Span) -> int | float:
    if operator in "/%":
        return _divide(operator, left, right, number, span)
    return _finish(_ARITHMETIC[operator](left, right), number)


def _divide(operator: str, left: int | float, right: int | float, number: Number, span: Span) -> int | float:
    if number is Number.FLOAT:
        return _divide_floats(operator, float(left), float(right))
    if right == 0:
        raise EvaluationError("division of an integer by zero", span)
    quotient = abs(int(left)) // abs(int(right))
    if (left < 0) != (right < 0):
        quotient = -quotient
    return _finish(quotient if operator == "/" else left - quotient * right, number)


def _divide_floats(operator: str, left: float, right: float) -> float:
    if operator == "%":
        return math.nan if right == 0 or math.isinf(left) else math.fmod(left, right)
    if right != 0:
        return left / right
    if left == 0 or math.isnan(left):
        return math.nan
    return math.copysign(math.inf, left) * math.copysign(1.0, right)


def _logic(operator: str, left: Expression, right: Expression, environment: Environment) -> bool:
    first = bool(evaluate(left, environment))
    match operator:
        case "and":
            return first and bool(evaluate(right, environment))
        case "or":
            return first or bool(evaluate(right, environment))
        case _:
            return not first or bool(evaluate(right, environment))


def _same(left: Value, right: Value) -> bool:
    if isinstance(left, Struct | Actor) or isinstance(right, Struct | Actor):
        return left is right
    if isinstance(left, tuple) and isinstance(right, tuple):
        return len(left) == len(right) and all(map(_same, left, right))
    return left == right


def _contains(item: Value, container: Value) -> bool:
    if isinstance(container, Range):
        return item in container
    assert isinstance(container, tuple)
    if isinstance(item, tuple):
        return all(_contains(part, container) for part in item)
    return any(_same(item, member) for member in container)


def _index(expression: Index, environment: Environment) -> Value:
    items = evaluate(expression.items, environment)
    position = evaluate(expression.position, environment)
    assert isinstance(items, tuple) and isinstance(position, int)
    if not 0 <= position < len(items):
        raise EvaluationError(f"index {position} is outside of a list of {len(items)}", expression.span)
    return items[position]


def _construct(expression: Construct, environment: Environment) -> Struct | Actor:
    made: Struct | Actor
    if isinstance(expression.type, ActorType):
        made = Actor(expression.type, environment.path)
    else:
        made = Struct(expression.type)
    for name, argument in expression.arguments:
        made.fields[name] = evaluate(argument, environment)
    for name, default in expression.defaults:
        path = f"{environment.path}.{name}" if environment.path else name
        made.fields[name] = evaluate(default, Environment(made, environment.bindings, path))
    return made


_ARITHMETIC: dict[str, Callable[[float, float], float]] = {
    "+": lambda left, right: left + right,
    "-": lambda left, right: left - right,
    "*": lambda left, right: left * right,
}

_COMPARISONS: dict[str, Callable[[Value, Value], bool]] = {
    "==": _same,
    "!=": lambda left, right: not _same(left, right),
    "<": lambda left, right: left < right,  # type: ignore[operator] # checked: numbers
    "<=": lambda left, right: left <= right,  # type: ignore[operator]
    ">": lambda left, right: left > right,  # type: ignore[operator]
    ">=": lambda left, right: left >= right,  # type: ignore[operator]
}
