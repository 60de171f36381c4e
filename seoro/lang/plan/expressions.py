"""Expressions of the plan."""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum
from typing import TYPE_CHECKING, Final, TypeAlias, get_args

from seoro.lang.frozen import Value
from seoro.lang.plan.types import EnumValue, StructType, ValueType
from seoro.lang.source import Span

if TYPE_CHECKING:
    from seoro.lang.plan.methods import Methods
    from seoro.lang.plan.structures import Structures


class Number(Enum):
    """In which arithmetic an operator works (7.4.2.3.1); physical values are floats."""

    INT = "int"
    UINT = "uint"
    FLOAT = "float"


class Reference(Value):
    """A variable itself, for an action that changes it.

    Args:
        path: The `Field` or `Member` that it is.
        type: What it holds.
        span: Its place in the text.
    """

    path: Expression
    type: ValueType
    span: Span


class Literal(Value):
    """A constant: bool, int, float (SI), string or `EnumValue`."""

    value: bool | int | float | str | EnumValue
    span: Span


class Field(Value):
    """A field of the instance in whose scope the expression stands (scenario, action, struct)."""

    name: str
    span: Span


class Binding(Value):
    """A name bound where the expression stands: `actor`, the event object of an `as` clause, a parameter of a
    method, or `it` in an operator on lists and in a method of a primitive type."""

    name: str
    span: Span


class Member(Value):
    """`<base>.<name>`: a field of a struct, an actor or an event object."""

    base: Expression
    name: str
    span: Span


class Labelled(Value):
    """What was invoked last under a label, for its fields and methods: labels hold instances (7.6.2.2).

    Args:
        path: A label of the scenario or action in whose scope the expression stands, then one of what is invoked
            under it, and so on.
        span: Its place in the text.
    """

    path: tuple[str, ...]
    span: Span


class Self(Value):
    """`it`, where it is the instance in whose scope the expression stands."""

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


class Bulk(Enum):
    """Operators that evaluate an expression for each member of a list (7.4.2.7.3)."""

    FILTER = "filter"
    FIRST_INDEX = "first_index"
    COUNT = "count"
    HAS = "has"
    MAP = "map"


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


class Side(Enum):
    """The bounds of a range."""

    LOWER = "lower"
    UPPER = "upper"


class Bound(Value):
    """`<range>.lower()` or `<range>.upper()`."""

    side: Side
    range: Expression
    span: Span


class StringMethod(Enum):
    """The methods of strings (8.13)."""

    LENGTH = "length"
    CONTAINS = "contains"
    SUBSTRING = "substring"
    SPLIT = "split"
    JOIN = "join"
    REPLACE = "replace"
    TRIM = "trim"


class StringCall(Value):
    """`<text>.<method>(<arguments>)`; arguments in the order of the method's parameters."""

    method: StringMethod
    text: Expression
    arguments: tuple[Expression, ...]
    span: Span


class RangeOf(Value):
    """`[low..high]` or `range(low, high)`; the lower bound is the smaller one, whichever comes first."""

    low: Expression
    high: Expression
    span: Span


class Index(Value):
    """`<items>[<position>]`."""

    items: Expression
    position: Expression
    span: Span


class Convert(Value):
    """A number as one of another numeric type, where the language converts implicitly (7.4.2.3.1, 7.4.2.6).

    Integers wrap. Of a list or a range, each element is converted.
    """

    operand: Expression
    number: Number
    span: Span


class TypeTest(Value):
    """`<operand>.is(<type>)`, where the value has to tell."""

    operand: Expression
    type: ValueType
    span: Span


class Cast(Value):
    """`<operand>.as(<type>)`, where the value has to tell whether it can be done (7.4.2.6)."""

    operand: Expression
    type: ValueType
    span: Span


class Construct(Value):
    """A struct value that is made where the expression stands.

    Args:
        type: What it is a value of.
        arguments: Values for fields, evaluated in the scope around; the others have what their structure says.
        structures: The structures of all types.
    """

    type: StructType
    arguments: tuple[tuple[str, Expression], ...]
    structures: Structures
    span: Span


class Call(Value):
    """A method applied to arguments (7.4.2.1), chosen by the type of the value.

    Args:
        receiver: Whose method it is; None for the instance in whose scope the expression stands.
        method: Its name in `methods`.
        arguments: What is given, in the order in which it is evaluated.
        methods: All methods of the program.
    """

    receiver: Expression | None
    method: str
    arguments: tuple[tuple[str, Expression], ...]
    methods: Methods
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
    """The expressions of which an expression consists, those in bodies of methods apart."""
    for name in expression.__match_args__:
        value = getattr(expression, name)
        if type(value) in _EXPRESSIONS:
            yield value
        elif isinstance(value, tuple):
            for item in value:
                inner = item[1] if isinstance(item, tuple) and len(item) == 2 else item
                if type(inner) in _EXPRESSIONS:
                    yield inner
