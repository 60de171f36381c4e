"""Evaluation of the plan's expressions.

Integers have 64 bits and wrap; `int / int` truncates toward zero; `%` takes the sign of the dividend. Floats
follow IEEE 754, including division by zero (7.4.2.3, 7.3.2).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, assert_never, cast

from seoro.lang.arithmetic import calculate, wrap
from seoro.lang.plan import (
    Arithmetic,
    Binding,
    Bound,
    Call,
    Cast,
    Compare,
    Concatenate,
    Conditional,
    Construct,
    Contains,
    Convert,
    Expression,
    Field,
    ForEach,
    Global,
    Index,
    Join,
    Labelled,
    ListOf,
    Literal,
    Logic,
    Member,
    Negate,
    Not,
    RangeOf,
    Reference,
    Self,
    Side,
    Size,
    StringCall,
    TypeTest,
    ValueType,
)
from seoro.lang.source import Span
from seoro.runtime.choose.plain import empty, is_plain, make_plain, scope_of
from seoro.runtime.expressions.lists import call_string, for_each
from seoro.runtime.functions.methods import call
from seoro.runtime.values.conversions import cast as convert
from seoro.runtime.values.conversions import is_of, range_between, to_number
from seoro.runtime.values.environment import Calls, Deferred, Environment, EvaluationError, NotInvoked
from seoro.runtime.values.values import Actor, Fields, HasFields, Invoker, Range, Struct, Value, Variable


def evaluate(expression: Expression, environment: Environment) -> Value:
    """Evaluate an expression.

    Raises:
        EvaluationError: It has no value.
    """
    match expression:
        case Literal(value):
            return value
        case Field(name, span):
            return _field(environment.instance, name, span, environment)
        case Labelled(path, span):
            return cast(Value, _labelled(path, environment, span))  # only its members are read
        case Self():
            return cast(Value, environment.instance)  # only its members are read
        case Global(name, span):
            return _field(environment.outermost, name, span, environment)
        case Binding(name):
            # An event object is not a value of the language, but only its members are read.
            return _bound(environment.bindings[name])
        case Member(base, name, span):
            return _field(cast(HasFields, evaluate(base, environment)), name, span, environment)
        case ListOf(items):
            return tuple(evaluate(item, environment) for item in items)
        case RangeOf(low, high):
            return range_between(_number(low, environment), _number(high, environment))
        case Join(lists):
            parts = [cast(tuple[Value, ...], evaluate(part, environment)) for part in lists]
            return tuple(item for part in parts for item in part)
        case Index():
            return _index(expression, environment)
        case Convert(operand, number):
            return to_number(evaluate(operand, environment), number)
        case Conditional():
            return _choose(expression, environment)
        case Construct():
            return _construct(expression, environment)
        case Call():
            return call(expression, environment, evaluate)
        case Reference(path, type_):
            return _variable(path, type_, environment)
        case _:
            return _operate(expression, environment)


def _operate(expression: Expression, environment: Environment) -> Value:
    match expression:
        case Negate(operand, number, span):
            return wrap(-_number(operand, environment), number)
        case Arithmetic() | Concatenate() | Compare() | Logic():
            return _chain(expression, environment)
        case Contains(item, container):
            return _contains(evaluate(item, environment), evaluate(container, environment))
        case Not(operand):
            return not evaluate(operand, environment)
        case Size(items):
            return len(cast(tuple[Value, ...], evaluate(items, environment)))
        case Bound(side, operand):
            found = cast(Range, evaluate(operand, environment))
            return found.low if side is Side.LOWER else found.high
        case ForEach():
            return for_each(expression, environment, evaluate)
        case StringCall():
            return call_string(expression, environment, evaluate)
        case TypeTest(operand, type_):
            return is_of(evaluate(operand, environment), type_)
        case Cast(operand, type_, span):
            return convert(evaluate(operand, environment), type_, span)
        case (
            Literal() | Field() | Binding() | Labelled() | Self() | Global() | Member() | Conditional() | ListOf()
            | Join() | RangeOf() | Index() | Convert() | Construct() | Call() | Reference()
        ):  # fmt: skip
            raise AssertionError("evaluated above")
        case _:
            assert_never(expression)


def _choose(expression: Expression, environment: Environment) -> Value:
    """Evaluate `? :`, without recursion: the last branch of a table may be a long chain."""
    while isinstance(expression, Conditional):
        is_true = evaluate(expression.condition, environment)
        expression = expression.then if is_true else expression.otherwise
    return evaluate(expression, environment)


def _labelled(path: tuple[str, ...], environment: Environment, span: Span) -> Invoker:
    """Return the last invocation under a path of labels."""
    found = cast(Invoker, environment.instance)
    for label in path:
        if environment.reads is not None:
            environment.reads.fields[id(found), label] = found
        latest = found.invoked(label)
        if latest is None:
            raise NotInvoked(f"the label `{label}` has not been invoked yet", span)
        found = latest
    return found


def _chain(expression: _Operation, environment: Environment) -> Value:
    """Evaluate a chain of operators from its left end, without recursion: chains may be long."""
    chain = [expression]
    while isinstance(left := chain[-1].left, _Operation):
        chain.append(left)
    value = evaluate(chain[-1].left, environment)
    for step in reversed(chain):
        value = _apply(step, value, environment)
    return value


def _apply(operation: _Operation, left: Value, environment: Environment) -> Value:
    """Evaluate an operation with a known left operand."""
    match operation:
        case Arithmetic(operator, _, right, number, span):
            assert isinstance(left, int | float)
            other = _number(right, environment)
            try:
                return calculate(operator, left, other, number)
            except ZeroDivisionError:
                raise EvaluationError("division of an integer by zero", span) from None
        case Concatenate(_, right):
            return f"{left}{evaluate(right, environment)}"
        case Compare(operator, _, right):
            return _COMPARISONS[operator](left, evaluate(right, environment))
        case Logic(operator, _, right):
            return _logic(operator, bool(left), right, environment)
        case _:
            assert_never(operation)


def _number(expression: Expression, environment: Environment) -> int | float:
    value = evaluate(expression, environment)
    assert isinstance(value, int | float)
    return value


def _bound(value: Value | HasFields | Deferred) -> Value:
    return evaluate(value.expression, value.environment) if isinstance(value, Deferred) else cast(Value, value)


def _field(holder: HasFields, name: str, span: Span, environment: Environment) -> Value:
    """Return the value of a field; a method of a value being constructed may read a missing field."""
    if environment.reads is not None:
        environment.reads.fields[id(holder), name] = holder
    try:
        return holder.fields[name]
    except KeyError:
        raise EvaluationError(f"`{name.rpartition('::')[2]}` has no value yet", span) from None


def _variable(path: Expression, type_: ValueType, environment: Environment) -> Variable[Any]:
    """Return the variable at the end of a path."""
    holder: HasFields = environment.instance
    if isinstance(path, Member):
        holder = cast(HasFields, evaluate(path.base, environment))
    assert isinstance(path, Field | Member), "checked: a path to a variable"
    return Variable(holder, path.name, type_, path.span.text)


def _logic(operator: str, first: bool, right: Expression, environment: Environment) -> bool:
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
        bounds = (item.low, item.high) if isinstance(item, Range) else (item,)
        return all(bound in container for bound in bounds)
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
    """Construct a struct.

    Raises:
        EvaluationError: An argument or a default has no value, or no values meet all constraints.
    """
    given = {name: evaluate(value, environment) for name, value in expression.arguments}
    structure = environment.plan.structures.of(expression.type)
    if is_plain(structure, given):
        return make_plain(structure, given, environment, evaluate)
    from seoro.runtime.choose.choose import choose  # noqa: PLC0415 - rarely needed
    from seoro.runtime.choose.slots import Slot, value_slot  # noqa: PLC0415 - rarely needed

    if environment.calls is None:
        environment = replace(environment, calls=Calls())
    made = empty(structure, environment.path, Fields())
    slot: Slot = value_slot(made, environment, expression.span)
    inside = scope_of(made, environment)
    choose(made, (structure,), given, inside, evaluate, value=slot)
    return made


_Operation = Arithmetic | Concatenate | Compare | Logic
_COMPARISONS: dict[str, Callable[[Value, Value], bool]] = {
    "==": _same,
    "!=": lambda left, right: not _same(left, right),
    "<": lambda left, right: left < right,  # type: ignore[operator] # checked: numbers
    "<=": lambda left, right: left <= right,  # type: ignore[operator]
    ">": lambda left, right: left > right,  # type: ignore[operator]
    ">=": lambda left, right: left >= right,  # type: ignore[operator]
}
