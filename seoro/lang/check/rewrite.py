"""Walks over expressions of the plan: what they refer to, and replacing it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeAlias, assert_never

from seoro.lang import plan

Reference: TypeAlias = plan.Field | plan.Binding


def fields_used(expression: plan.Expression) -> set[str]:
    """Names of the fields that an expression reads, of the instance in whose scope it stands."""
    found: set[str] = set()

    def note(reference: Reference) -> plan.Expression:
        if isinstance(reference, plan.Field):
            found.add(reference.name)
        return reference

    rewrite(expression, note)
    return found


def substitute(
    expression: plan.Expression, fields: Mapping[str, plan.Expression], actor: plan.Expression | None
) -> plan.Expression:
    """The expression with values in the place of fields and of `actor`, to stand in another scope."""

    def put(reference: Reference) -> plan.Expression:
        if isinstance(reference, plan.Field):
            return fields.get(reference.name, reference)
        return actor if reference.name == "actor" and actor is not None else reference

    return rewrite(expression, put)


def rewrite(expression: plan.Expression, leaf: Callable[[Reference], plan.Expression]) -> plan.Expression:
    """The expression with each reference to a field or a binding replaced.

    The defaults of constructed values have a scope of their own and stay as they are.
    """

    def go(inner: plan.Expression) -> plan.Expression:
        return rewrite(inner, leaf)

    match expression:
        case plan.Literal():
            return expression
        case plan.Field() | plan.Binding():
            return leaf(expression)
        case plan.Member(base):
            return replace(expression, base=go(base))
        case plan.Negate(operand) | plan.Not(operand) | plan.Convert(operand):
            return replace(expression, operand=go(operand))
        case plan.Arithmetic() | plan.Concatenate() | plan.Compare() | plan.Logic():
            return replace(expression, left=go(expression.left), right=go(expression.right))
        case plan.Contains(item, container):
            return replace(expression, item=go(item), container=go(container))
        case plan.Conditional(condition, then, otherwise):
            return replace(expression, condition=go(condition), then=go(then), otherwise=go(otherwise))
        case plan.ListOf(items):
            return replace(expression, items=tuple(go(item) for item in items))
        case plan.RangeOf(low, high):
            return replace(expression, low=go(low), high=go(high))
        case plan.Index(items, position):
            return replace(expression, items=go(items), position=go(position))
        case plan.Construct(arguments=arguments):
            return replace(expression, arguments=tuple((name, go(value)) for name, value in arguments))
        case _:
            assert_never(expression)
