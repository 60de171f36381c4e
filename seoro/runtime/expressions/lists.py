"""Operators on list members (7.4.2.7.3), and methods of strings (8.13)."""

from __future__ import annotations

from typing import assert_never

from seoro.lang.plan import Bulk, ForEach, StringCall, StringMethod
from seoro.runtime.values.environment import Environment, Evaluate, EvaluationError
from seoro.runtime.values.values import Value


def for_each(expression: ForEach, environment: Environment, evaluate: Evaluate) -> Value:
    """Evaluate `filter(...)` and similar methods, with each member as `it`."""
    items = evaluate(expression.items, environment)
    assert isinstance(items, tuple)

    def about(item: Value) -> Value:
        inside = environment.bind(it=item)
        return evaluate(expression.body, inside)

    match expression.operator:
        case Bulk.FILTER:
            return tuple(item for item in items if about(item))
        case Bulk.FIRST_INDEX:
            return next((index for index, item in enumerate(items) if about(item)), -1)
        case Bulk.COUNT:
            return sum(1 for item in items if about(item))
        case Bulk.HAS:
            return any(about(item) for item in items)
        case Bulk.MAP:
            return tuple(about(item) for item in items)
        case _:
            assert_never(expression.operator)


def call_string(expression: StringCall, environment: Environment, evaluate: Evaluate) -> Value:
    """Evaluate a method of a string.

    Raises:
        EvaluationError: The separator of `split` is empty.
    """
    text = evaluate(expression.text, environment)
    arguments = [evaluate(argument, environment) for argument in expression.arguments]
    assert isinstance(text, str)
    match expression.method, arguments:
        case StringMethod.LENGTH, []:
            return len(text)
        case StringMethod.CONTAINS, [str(part)]:
            return part in text
        case StringMethod.SUBSTRING, [int(start)]:
            return text[start:]
        case StringMethod.SUBSTRING, [int(start), int(end)]:
            return text[start:end]
        case StringMethod.SPLIT, [""]:
            raise EvaluationError("empty separator in `split`; expected at least one character", expression.span)
        case StringMethod.SPLIT, [str(separator)]:
            return tuple(text.split(separator))
        case StringMethod.JOIN, [tuple(parts)]:
            return text.join(str(part) for part in parts)
        case StringMethod.REPLACE, [str(old), str(new)]:
            return text.replace(old, new)
        case StringMethod.TRIM, []:
            return text.strip()
        case _:
            raise AssertionError("checked: these are the arguments of the method")
