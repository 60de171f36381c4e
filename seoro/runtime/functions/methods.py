"""Calls of methods (7.3.7), dispatched on the type of the value.

An external method is a Python function, bound when the scenario was loaded (`external.py`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from seoro.lang.plan import Call, EnumValue, External, Method, Methods, Undefined
from seoro.lang.source import Span
from seoro.runtime.values.environment import Environment, Evaluate, EvaluationError
from seoro.runtime.values.values import Actor, HasFields, Struct, Value

MAX_DEPTH = 64  # of nested method calls; far below the limit of Python's stack


class MethodFailed(Exception):
    """The Python function of a method failed, or returned an invalid value."""


def call(expression: Call, environment: Environment, evaluate: Evaluate) -> Value:
    """Call a method that has a result, and return it.

    Raises:
        EvaluationError: As for `invoke`.
    """
    result = invoke(expression, environment, evaluate)
    assert result is not None, "checked: the method has a result"
    return result


def invoke(expression: Call, environment: Environment, evaluate: Evaluate) -> Value | None:
    """Call a method; return its result, or None if it has none.

    Raises:
        EvaluationError: The method is undefined, is nested too deeply, or its Python function failed.
    """
    if environment.depth >= MAX_DEPTH:
        raise _too_deep(expression.span)
    holder: Value | HasFields = environment.instance
    if expression.receiver is not None:
        holder = evaluate(expression.receiver, environment)
    method = implementation(expression, holder, environment.plan.methods)
    given = {name: evaluate(value, environment) for name, value in expression.arguments}
    within = inside(expression, holder, environment)
    try:
        return _perform(method, given, within, expression, evaluate)
    except RecursionError:
        if environment.depth > 0:
            raise
        raise _too_deep(expression.span) from None


def implementation(expression: Call, holder: Value | HasFields, methods: Methods) -> Method:
    """Return the implementation of a method for a value."""
    method = methods.find(_types(holder), expression.method)
    assert method is not None, "checked: the type has the method"
    return method


def _too_deep(span: Span) -> EvaluationError:
    return EvaluationError(f"method calls are nested more than {MAX_DEPTH} deep", span)


def _types(holder: Value | HasFields) -> Iterable[str]:
    """Return the type names of a value, nearest first."""
    match holder:
        case Struct() | Actor():
            return holder.types
        case bool():
            return ("bool",)
        case int() | float():
            return ("int", "uint", "float")  # the method's name selects one of them
        case str():
            return ("string",)
        case _:
            return holder.types  # type: ignore[union-attr, no-any-return] # nothing else has methods


def inside(expression: Call, holder: Value | HasFields, environment: Environment) -> Environment:
    """Return the environment within a method; it inherits `actor` only if it has the same instance."""
    bindings: dict[str, Value | HasFields] = {"it": holder}
    if expression.receiver is None and "actor" in environment.bindings:
        bindings["actor"] = environment.bindings["actor"]
    is_instance = not isinstance(holder, bool | int | float | str | tuple | EnumValue)
    instance = holder if is_instance else environment.instance
    calls = environment.calls
    return replace(
        environment,
        instance=instance,  # type: ignore[arg-type] # other values have fields
        bindings=bindings,
        scenario=environment.outermost,
        depth=environment.depth + 1,
        calls=calls.within(expression.span, environment.instance) if calls is not None else None,
    )


def _perform(
    method: Method, given: dict[str, Value], inside: Environment, call: Call, evaluate: Evaluate
) -> Value | None:
    bindings = dict(inside.bindings)
    inside = replace(inside, bindings=bindings)
    arguments: dict[str, Value] = {}
    for name, default in method.parameters:
        if name not in given:
            assert default is not None, "checked: it has a value or a default"
            given[name] = evaluate(default, inside)
        bindings[name] = arguments[name] = given[name]
    body = method.body
    if isinstance(body, Undefined):
        raise EvaluationError(f"method `{method.name}` is undefined", call.span)
    if isinstance(body, External):
        return _call_python(body, arguments, inside, call, evaluate)
    return evaluate(body, inside)


def _call_python(
    external: External, arguments: dict[str, Value], inside: Environment, call: Call, evaluate: Evaluate
) -> Value | None:
    function = inside.plan.methods.function(external)
    if function is None:
        raise EvaluationError(f"`{external.path}` was not imported when the scenario was loaded", call.span)
    if inside.reads is not None:
        inside.reads.is_external = True
    positional = [evaluate(argument.value, inside) for argument in external.positional]
    named = {name: evaluate(argument.value, inside) for name, argument in external.named}
    given = {**arguments, **named}
    results = inside.calls.results if inside.calls is not None else {}
    key = (inside.calls.place if inside.calls is not None else (), *positional, *given.items())
    if key in results:
        return results[key]
    try:
        result: Value | None = function(inside.run, positional, given)
    except MethodFailed as error:
        raise EvaluationError(str(error), call.span) from error
    if result is not None:
        results[key] = result
    return result
