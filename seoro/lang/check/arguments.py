"""Binding arguments to parameters: positional ones by their place, then named ones (7.4.2.1)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from seoro.lang import ast, plan
from seoro.lang.diagnostics import behaviors as messages
from seoro.lang.diagnostics import types as type_messages
from seoro.lang.diagnostics.unsupported import Construct, NotSupported
from seoro.lang.source import Span
from seoro.lang.symbols import FieldSymbol
from seoro.lang.traits import ParameterTrait
from seoro.lang.types import is_known

if TYPE_CHECKING:
    from seoro.lang.check.expressions import Expressions, Scope

_NO_TRAITS: Mapping[str, ParameterTrait] = {}


def bind(
    expressions: Expressions,
    owner: str,
    parameters: Mapping[str, FieldSymbol],
    arguments: ast.ArgumentList | None,
    scope: Scope,
    is_open: bool = False,
    traits: Mapping[str, ParameterTrait] = _NO_TRAITS,
) -> dict[str, plan.Expression]:
    """The values of the parameters that are given, in the order in which they are given.

    Args:
        expressions: For the values, and for messages.
        owner: What takes the arguments, for messages.
        parameters: Its parameters, in their order.
        arguments: The arguments; None if there are none.
        scope: Where they stand.
        is_open: Whether there may be parameters that are not known.
        traits: What a Python implementation takes for parameters, where it differs from the declaration.
    """
    given: dict[str, plan.Expression] = {}
    places: dict[str, Span] = {}
    if arguments is None:
        return given
    order = list(parameters)
    for place, value in enumerate(arguments.positional):
        if place < len(order):
            places[order[place]] = value.span
            given[order[place]] = _argument(expressions, owner, parameters[order[place]], value, scope, traits)
        else:
            expressions.value(value, scope)
            if not is_open:
                expressions.bag.add(messages.TooManyArguments(value.span, owner, len(order)))
    for argument in arguments.named:
        name = argument.name.text
        if name not in parameters:
            expressions.value(argument.value, scope)
            if name == "duration":
                expressions.bag.add(NotSupported(argument.name.span, Construct.DURATION))
            elif not is_open and not expressions.program.is_lenient:
                expressions.bag.add(messages.UnknownArgument(argument.name.span, owner, name, tuple(order)))
            continue
        if name in places:
            expressions.bag.add(messages.ArgumentTwice(argument.name.span, name, places[name]))
        places[name] = argument.name.span
        given[name] = _argument(expressions, owner, parameters[name], argument.value, scope, traits)
    return given


def _argument(
    expressions: Expressions,
    owner: str,
    parameter: FieldSymbol,
    value: ast.Expression,
    scope: Scope,
    traits: Mapping[str, ParameterTrait],
) -> plan.Expression:
    trait = traits.get(parameter.name, ParameterTrait.VALUE)
    if trait is ParameterTrait.REFERENCE:
        expressions.bag.add(NotSupported(value.span, Construct.REFERENCE))
        return plan.Literal(False, value.span)
    if trait is ParameterTrait.ANY:
        found = expressions.value(value, scope)
        if expressions.strict and is_known(found.type) and found.type != parameter.type:
            declared = expressions.converter.describe(parameter.type)
            expressions.bag.add(type_messages.AnyArgument(value.span, parameter.name, declared))
        return found.expression
    context = f"`{parameter.name}` of `{owner}`"
    return expressions.converted(value, parameter.type, scope, context, is_argument=True)
