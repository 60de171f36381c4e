"""Expressions of the plan."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from enum import Enum
from typing import Final, TypeAlias, get_args

from seoro.lang.arithmetic import Number
from seoro.lang.frozen import Value
from seoro.lang.plan.types import EnumValue, StructType, ValueType
from seoro.lang.source import Span


class Bulk(Enum):
    """Operators that evaluate an expression for each member of a list (7.4.2.7.3)."""

    FILTER = "filter"
    FIRST_INDEX = "first_index"
    COUNT = "count"
    HAS = "has"
    MAP = "map"


class Side(Enum):
    """The bounds of a range."""

    LOWER = "lower"
    UPPER = "upper"


class StringMethod(Enum):
    """The methods of strings (8.13)."""

    LENGTH = "length"
    CONTAINS = "contains"
    SUBSTRING = "substring"
    SPLIT = "split"
    JOIN = "join"
    REPLACE = "replace"
    TRIM = "trim"


class Reference(Value):
    """A variable itself, for an action that changes it.

    Args:
        path: Its `Field` or `Member`.
        type: Type of its values.
        span: Its span.
    """

    path: Expression
    type: ValueType
    span: Span


class Literal(Value):
    """A constant: bool, int, float (SI), string or `EnumValue`."""

    value: bool | int | float | str | EnumValue
    span: Span


class Field(Value):
    """A field of the instance of the scope (scenario, action, struct)."""

    name: str
    span: Span


class Binding(Value):
    """A bound name.

    It is `actor`, the event object of an `as` clause, a parameter of a method, or `it` in an operator on lists and
    in a method of a primitive type.
    """

    name: str
    span: Span


class Member(Value):
    """`<base>.<name>`: a field of a struct, an actor or an event object."""

    base: Expression
    name: str
    span: Span


class Labelled(Value):
    """The last invoked instance of a label, for its fields and methods (7.6.2.2).

    Args:
        path: A label of the scenario or action of the scope, then one of the invoked behavior, and so on.
        span: Its span.
    """

    path: tuple[str, ...]
    span: Span


class Self(Value):
    """`it` as the instance of the scope."""

    span: Span


class Global(Value):
    """A global parameter, by its name in `Plan.globals`."""

    name: str
    span: Span


class Negate(Value):
    """Unary minus."""

    operand: Expression
    number: Number
    span: Span


class Arithmetic(Value):
    """`+ - * / %` of two numbers."""

    operator: str
    left: Expression
    right: Expression
    number: Number
    span: Span


class Concatenate(Value):
    """`+` of two strings."""

    left: Expression
    right: Expression
    span: Span


class Compare(Value):
    """`== != < <= > >=`."""

    operator: str
    left: Expression
    right: Expression
    span: Span


class Contains(Value):
    """`<item> in <container>`, a list or a range."""

    item: Expression
    container: Expression
    span: Span


class Not(Value):
    """`not <operand>`."""

    operand: Expression
    span: Span


class Logic(Value):
    """`and`, `or`, `=>`, all short-circuiting (7.4.2.2)."""

    operator: str
    left: Expression
    right: Expression
    span: Span


class Conditional(Value):
    """`<condition> ? <then> : <otherwise>`."""

    condition: Expression
    then: Expression
    otherwise: Expression
    span: Span


class ListOf(Value):
    """`[a, b]`, or the empty default of a list field."""

    items: tuple[Expression, ...]
    span: Span


class Join(Value):
    """A list of the members of several lists, in their order (7.4.2.7.4)."""

    lists: tuple[Expression, ...]
    span: Span


class ForEach(Value):
    """`<items>.<operator>(<body>)`; in the body, the binding `it` is the member."""

    operator: Bulk
    items: Expression
    body: Expression
    span: Span


class Size(Value):
    """`<items>.size()`."""

    items: Expression
    span: Span


class Bound(Value):
    """`<range>.lower()` or `<range>.upper()`."""

    side: Side
    range: Expression
    span: Span


class StringCall(Value):
    """`<text>.<method>(<arguments>)`; arguments in the order of the method's parameters."""

    method: StringMethod
    text: Expression
    arguments: tuple[Expression, ...]
    span: Span


class RangeOf(Value):
    """`[low..high]` or `range(low, high)`; the bounds may stand in either order."""

    low: Expression
    high: Expression
    span: Span


class Index(Value):
    """`<items>[<position>]`."""

    items: Expression
    position: Expression
    span: Span


class Convert(Value):
    """An implicit conversion to another numeric type (7.4.2.3.1, 7.4.2.6).

    Integers wrap. Of a list or a range, each element is converted.
    """

    operand: Expression
    number: Number
    span: Span


class TypeTest(Value):
    """`<operand>.is(<type>)`, if the result depends on the value."""

    operand: Expression
    type: ValueType
    span: Span


class Cast(Value):
    """`<operand>.as(<type>)`, if its success depends on the value (7.4.2.6)."""

    operand: Expression
    type: ValueType
    span: Span


class Construct(Value):
    """A newly constructed struct value.

    Args:
        type: Its type.
        arguments: Values for fields, evaluated in the enclosing scope; other fields follow their structure.
    """

    type: StructType
    arguments: tuple[tuple[str, Expression], ...]
    span: Span


class Call(Value):
    """A method applied to arguments (7.4.2.1), chosen by the type of the value.

    Args:
        receiver: The receiver; None for the instance of the scope.
        method: Its name in `Plan.methods`.
        arguments: The arguments, in the order of evaluation.
    """

    receiver: Expression | None
    method: str
    arguments: tuple[tuple[str, Expression], ...]
    span: Span


Expression: TypeAlias = (
    Literal
    | Field
    | Binding
    | Labelled
    | Self
    | Global
    | Member
    | Negate
    | Arithmetic
    | Concatenate
    | Compare
    | Contains
    | Not
    | Logic
    | Conditional
    | ListOf
    | Join
    | ForEach
    | Size
    | Bound
    | StringCall
    | RangeOf
    | Index
    | Convert
    | TypeTest
    | Cast
    | Construct
    | Call
    | Reference
)


_EXPRESSIONS: Final = frozenset(get_args(Expression))


def parts(expression: Expression) -> Iterable[Expression]:
    """Yield the parts of an expression, except bodies of methods."""
    for name in expression.__match_args__:
        value = getattr(expression, name)
        if type(value) in _EXPRESSIONS:
            yield value
        elif isinstance(value, tuple):
            for item in value:
                inner = item[1] if isinstance(item, tuple) and len(item) == 2 else item
                if type(inner) in _EXPRESSIONS:
                    yield inner


def walk(expression: Expression) -> Iterator[Expression]:
    """Yield an expression and all of its parts, except bodies of methods."""
    pending = [expression]
    while pending:
        part = pending.pop()
        yield part
        pending += parts(part)
