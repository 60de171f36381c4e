"""Values in a condition, to explain why it did not hold."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import cast

from seoro.lang import plan as plan_
from seoro.runtime.explanation import Reading
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.values.environment import Environment
from seoro.runtime.values.text import value_text
from seoro.runtime.values.values import Actor, HasFields, Range, Struct, Value, plain

_MOST = 8  # readings of one condition
_LONGEST = 80  # characters of a text
_DIGITS = 6  # of floats
_UNCOMPUTED = (plan_.Field, plan_.Global, plan_.Member, plan_.Index, plan_.Call, plan_.Literal, plan_.RangeOf)


def short(text: str) -> str:
    """Shorten a text of the scenario to one line."""
    line = " ".join(text.split())
    return line if len(line) <= _LONGEST else line[: _LONGEST - 3] + "..."


def read_condition(
    condition: plan_.EventCondition | None, environment: Environment, plan: plan_.Plan
) -> tuple[Reading, ...]:
    """Read the values that a condition depends on; for a time condition, those of its duration."""
    match condition:
        case plan_.Holds(expression) | plan_.Rise(expression) | plan_.Fall(expression):
            return read(_informative_parts(expression), environment, plan)
        case None | plan_.Every():
            return ()
        case _:
            return read(_informative_parts(condition.duration), environment, plan)


def read(
    expressions: Iterable[plan_.Expression], environment: Environment, plan: plan_.Plan
) -> tuple[Reading, ...]:
    """Read the values of expressions, once per text."""
    found: dict[str, Reading] = {}
    for expression in expressions:
        text = short(expression.span.text)
        if text not in found and len(found) < _MOST:
            reading = _read(text, expression, environment, plan)
            if reading is not None:
                found[text] = reading
    return tuple(found.values())


def _read(text: str, expression: plan_.Expression, environment: Environment, plan: plan_.Plan) -> Reading | None:
    try:
        value = evaluate(expression, environment)
    except Exception as error:  # external methods may raise anything
        return Reading(text, None, error=str(error))
    if not isinstance(value, bool | int | float | str | tuple | Range) and not hasattr(value, "member"):
        return None  # objects have no short text
    return _reading(text, value, _type_of(expression, environment, plan), plan)


def _reading(text: str, value: Value, type_: plan_.ValueType | None, plan: plan_.Plan) -> Reading:
    shown = short(value_text(value, type_, plan.structures, _DIGITS))
    return Reading(text, plain(value), unit_of(type_), shown=shown)


def unit_of(type_: plan_.ValueType | None) -> str:
    """Return the unit of a type, or an empty text."""
    return type_.unit if isinstance(type_, plan_.PhysicalType) else ""


def _informative_parts(expression: plan_.Expression) -> Iterator[plan_.Expression]:
    """Yield the informative parts of an expression: computed sides of comparisons, then names."""
    match expression:
        case plan_.Field() | plan_.Global() | plan_.Member() | plan_.Index() | plan_.Call():
            yield expression
        case plan_.Compare(_, left, right):
            yield from (side for side in (left, right) if not isinstance(side, _UNCOMPUTED))
            yield from _informative_parts(left)
            yield from _informative_parts(right)
        case _:
            for part in plan_.parts(expression):
                yield from _informative_parts(part)


def _type_of(expression: plan_.Expression, environment: Environment, plan: plan_.Plan) -> plan_.ValueType | None:
    """Return the type of a path or a sum of paths; None for other expressions."""
    match expression:
        case plan_.Field(name):
            return field_type(environment.instance, name, plan)
        case plan_.Global(name):
            field = plan.globals.fields.get(name)
            return field.type if field is not None else None
        case plan_.Member(base, name):
            return field_type(cast(HasFields, evaluate(base, environment)), name, plan)
        case plan_.Index(items):
            found = _type_of(items, environment, plan)
            return found.element if isinstance(found, plan_.ListType) else None
        case plan_.Arithmetic("+" | "-" | "%", left) | plan_.Negate(left):
            return _type_of(left, environment, plan)
        case _:
            return None


def field_type(holder: HasFields, name: str, plan: plan_.Plan) -> plan_.ValueType | None:
    """Return the declared type of a field."""
    if isinstance(holder, Struct | Actor):
        structure = plan.structures.find(holder.type)
    else:
        structure = getattr(getattr(holder, "declaration", None), "structure", None)
    field = structure.fields.get(name) if structure is not None else None
    return field.type if field is not None else None


def read_arguments(
    invocation: plan_.InvokeAction | None, holder: HasFields, names: Iterable[str], plan: plan_.Plan
) -> tuple[Reading, ...]:
    """Read the values of parameters, except those given as constants."""
    texts = dict(invocation.arguments) if invocation is not None else {}
    types = dict(invocation.types) if invocation is not None else {}
    readings = []
    for name in names:
        expression = texts.get(name)
        if isinstance(expression, plan_.Literal) or name not in holder.fields:
            continue
        text = f"{name}: {short(expression.span.text)}" if expression is not None else name
        value: Value = holder.fields[name]
        readings.append(_reading(text, value, types.get(name) or field_type(holder, name, plan), plan))
    return tuple(readings[:_MOST])
