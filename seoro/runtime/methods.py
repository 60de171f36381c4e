"""Calls of methods (7.3.7): the type of the value decides which implementation is reached.

An external method is a Python function that was bound when the scenario was loaded (`functions.py`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from seoro.lang.plan import Call, EnumValue, External, Method, Undefined
from seoro.lang.source import Span
from seoro.runtime.environment import Environment, Evaluate, EvaluationError
from seoro.runtime.functions import MethodFailed
from seoro.runtime.values import Actor, HasFields, Struct, Value

MAX_DEPTH = 64  # of methods that call each other; far below what the stack of Python bears


def call(expression: Call, environment: Environment, evaluate: Evaluate) -> Value:
    """The result of a method that has one.

    Raises:
        EvaluationError: As for `invoke`.
    """
    result = invoke(expression, environment, evaluate)
    assert result is not None, "checked: the method has a result"
    return result


def invoke(expression: Call, environment: Environment, evaluate: Evaluate) -> Value | None:
    """The result of a method; None if the method has none.

    Raises:
        EvaluationError: It has none: it is undefined, calls itself too deeply, or its Python function fails.
    """
    if environment.depth >= MAX_DEPTH:
        raise _too_deep(expression.span)
    holder: Value | HasFields = environment.instance
    if expression.receiver is not None:
        holder = evaluate(expression.receiver, environment)
    method = implementation(expression, holder)
    given = {name: evaluate(value, environment) for name, value in expression.arguments}
    within = inside(expression, holder, environment)
    try:
        return _perform(method, given, within, expression, evaluate)
    except RecursionError:
        if environment.depth > 0:
            raise
        raise _too_deep(expression.span) from None


def implementation(expression: Call, holder: Value | HasFields) -> Method:
    """The implementation that a call reaches on a value."""
    method = expression.methods.find(_types(holder), expression.method)
    assert method is not None, "checked: the type has the method"
    return method


def _too_deep(span: Span) -> EvaluationError:
    return EvaluationError(f"methods call each other more than {MAX_DEPTH} deep", span)


def _types(holder: Value | HasFields) -> Iterable[str]:
    """The names of the types of a value, nearest first."""
    match holder:
        case Struct() | Actor():
            return holder.types
        case bool():
            return ("bool",)
        case int() | float():
            return ("int", "uint", "float")  # the method's name tells which of them it is
        case str():
            return ("string",)
        case _:
            return holder.types  # type: ignore[union-attr, no-any-return] # nothing else has methods


def inside(expression: Call, holder: Value | HasFields, environment: Environment) -> Environment:
    """What names in a method stand for; of the bindings around it, it sees `actor` if it has the same instance."""
    bindings: dict[str, Value | HasFields] = {"it": holder}
    if expression.receiver is None and "actor" in environment.bindings:
        bindings["actor"] = environment.bindings["actor"]
    is_instance = not isinstance(holder, bool | int | float | str | tuple | EnumValue)
    instance = holder if is_instance else environment.instance
    calls = environment.calls
    return replace(
        environment,
        instance=instance,  # type: ignore[arg-type] # all others have fields
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
    function = call.methods.function(external)
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
