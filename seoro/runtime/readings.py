"""The values in a condition, for people who want to know why it did not hold."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import cast

from seoro.lang.plan import (
    Arithmetic,
    Call,
    Compare,
    EventCondition,
    Every,
    Expression,
    Fall,
    Field,
    Global,
    Holds,
    Index,
    InvokeAction,
    ListType,
    Literal,
    Member,
    Negate,
    PhysicalType,
    Plan,
    RangeOf,
    Rise,
    ValueType,
    parts,
)
from seoro.runtime.environment import Environment
from seoro.runtime.evaluate import evaluate
from seoro.runtime.explanation import Reading
from seoro.runtime.value_text import value_text
from seoro.runtime.values import Actor, HasFields, Range, Struct, Value, plain

_MOST = 8  # readings of one condition
_LONGEST = 80  # characters of a text
_DIGITS = 6  # of floats


def short(text: str) -> str:
    """A text of the scenario in one line, without its end if it is long."""
    line = " ".join(text.split())
    return line if len(line) <= _LONGEST else line[: _LONGEST - 3] + "..."


def read_condition(condition: EventCondition | None, environment: Environment, plan: Plan) -> tuple[Reading, ...]:
    """The values of all that a condition depends on; for one on time, of its duration if that is no constant."""
    match condition:
        case Holds(expression) | Rise(expression) | Fall(expression):
            return read(_telling(expression), environment, plan)
        case None | Every():
            return ()
        case _:
            return read(_telling(condition.duration), environment, plan)


def read(expressions: Iterable[Expression], environment: Environment, plan: Plan) -> tuple[Reading, ...]:
    """The values of some expressions; of those that are written alike, once."""
    found: dict[str, Reading] = {}
    for expression in expressions:
        text = short(expression.span.text)
        if text not in found and len(found) < _MOST:
            reading = _read(text, expression, environment, plan)
            if reading is not None:
                found[text] = reading
    return tuple(found.values())


def _read(text: str, expression: Expression, environment: Environment, plan: Plan) -> Reading | None:
    try:
        value = evaluate(expression, environment)
    except Exception as error:  # a method of someone else's may raise anything
        return Reading(text, None, error=str(error))
    if not isinstance(value, bool | int | float | str | tuple | Range) and not hasattr(value, "member"):
        return None  # objects are told apart by their fields
    return _reading(text, value, _type_of(expression, environment, plan), plan)


def _reading(text: str, value: Value, type_: ValueType | None, plan: Plan) -> Reading:
    shown = short(value_text(value, type_, plan.structures, _DIGITS))
    return Reading(text, plain(value), unit_of(type_), shown=shown)


def unit_of(type_: ValueType | None) -> str:
    """The unit of values of a type; empty if it has none."""
    return type_.unit if isinstance(type_, PhysicalType) else ""


def _telling(expression: Expression) -> Iterator[Expression]:
    """What in an expression people want the value of: sides of comparisons that are computed, then names."""
    match expression:
        case Field() | Global() | Member() | Index() | Call():
            yield expression
        case Compare(_, left, right):
            for side in (left, right):
                if not isinstance(side, Field | Global | Member | Index | Call | Literal | RangeOf):
                    yield side
            yield from _telling(left)
            yield from _telling(right)
        case _:
            for part in parts(expression):
                yield from _telling(part)


def _type_of(expression: Expression, environment: Environment, plan: Plan) -> ValueType | None:
    """The type of what a path leads to, and of sums of such; None for other expressions."""
    match expression:
        case Field(name):
            return field_type(environment.instance, name, plan)
        case Global(name):
            field = plan.globals.fields.get(name)
            return field.type if field is not None else None
        case Member(base, name):
            return field_type(cast(HasFields, evaluate(base, environment)), name, plan)
        case Index(items):
            found = _type_of(items, environment, plan)
            return found.element if isinstance(found, ListType) else None
        case Arithmetic("+" | "-" | "%", left) | Negate(left):
            return _type_of(left, environment, plan)
        case _:
            return None


def field_type(holder: HasFields, name: str, plan: Plan) -> ValueType | None:
    """The declared type of a field."""
    if isinstance(holder, Struct | Actor):
        structure = plan.structures.find(holder.type)
    else:
        structure = getattr(getattr(holder, "declaration", None), "structure", None)
    field = structure.fields.get(name) if structure is not None else None
    return field.type if field is not None else None


def read_arguments(
    invocation: InvokeAction | None, holder: HasFields, names: Iterable[str], plan: Plan
) -> tuple[Reading, ...]:
    """The values of parameters; those that the text gives as constants are not told again."""
    texts = dict(invocation.arguments) if invocation is not None else {}
    types = dict(invocation.types) if invocation is not None else {}
    readings = []
    for name in names:
        expression = texts.get(name)
        if isinstance(expression, Literal) or name not in holder.fields:
            continue
        text = f"{name}: {short(expression.span.text)}" if expression is not None else name
        value: Value = holder.fields[name]
        readings.append(_reading(text, value, types.get(name) or field_type(holder, name, plan), plan))
    return tuple(readings[:_MOST])
