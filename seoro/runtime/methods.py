"""Calls of methods (7.3.7): the type of the value decides which implementation is reached.

An external method is a Python function, imported by its dotted path when it is called first. It takes values as
the plan's table lists them and gives one back; anything else that it does is an error with its name.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable
from dataclasses import replace
from importlib import import_module
from typing import Any

from seoro.lang.plan import Call, EnumValue, External, Method, Undefined
from seoro.lang.source import Span
from seoro.runtime.conversions import from_python
from seoro.runtime.environment import Environment, Evaluate, EvaluationError, HasFields
from seoro.runtime.values import Actor, Struct, Value

MAX_DEPTH = 64  # of methods that call each other; far below what the stack of Python bears


def call(expression: Call, environment: Environment, evaluate: Evaluate) -> Value:
    """The result of a method.

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
    within = inside(holder, expression.receiver is None, environment)
    try:
        return _perform(method, given, within, expression.span, evaluate)
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


def inside(holder: Value | HasFields, is_own: bool, environment: Environment) -> Environment:
    """What names in a method stand for; of the bindings around it, it sees `actor` if it has the same instance."""
    bindings: dict[str, Value | HasFields] = {"it": holder}
    if is_own and "actor" in environment.bindings:
        bindings["actor"] = environment.bindings["actor"]
    is_instance = not isinstance(holder, bool | int | float | str | tuple | EnumValue)
    instance = holder if is_instance else environment.instance
    return replace(
        environment,
        instance=instance,  # type: ignore[arg-type] # all others have fields
        bindings=bindings,
        scenario=environment.outermost,
        depth=environment.depth + 1,
    )


def _perform(
    method: Method, given: dict[str, Value], inside: Environment, span: Span, evaluate: Evaluate
) -> Value:
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
        raise EvaluationError(f"method `{method.name}` is undefined", span)
    if isinstance(body, External):
        positional = [evaluate(value, inside) for value in body.positional]
        named = {name: evaluate(value, inside) for name, value in body.named}
        return _call_python(method, body.path, positional, {**arguments, **named}, span)
    return evaluate(body, inside)


def _call_python(method: Method, path: str, positional: list[Value], named: dict[str, Value], span: Span) -> Value:
    function = _find_function(path, span)
    try:
        result = function(*positional, **named)
    except Exception as error:
        reason = f"`{path}` failed: {type(error).__name__}: {error}"
        raise EvaluationError(reason, span) from error
    assert method.result is not None, "checked: it has a result"
    value = from_python(result, method.result)
    if value is None:
        expected = getattr(method.result, "name", "a list or a range")
        found = type(result).__name__
        raise EvaluationError(f"`{path}` returned a value of {found}, which is no `{expected}`", span)
    return value


def _find_function(path: str, span: Span) -> Callable[..., Any]:
    """The Python function at a dotted path: of a module, or of a class in one."""
    parts = path.split(".")
    found: Any = None
    for length in range(len(parts) - 1, 0, -1):
        name = ".".join(parts[:length])
        try:
            found = import_module(name)
            break
        except ModuleNotFoundError as error:
            if error.name is None or not f"{name}.".startswith(f"{error.name}."):
                raise EvaluationError(f"`{path}` cannot be imported: {error}", span) from error
        except Exception as error:
            raise EvaluationError(f"`{path}` cannot be imported: {error}", span) from error
    if found is None:
        raise EvaluationError(f"there is no Python module for `{path}`", span)
    for part in parts[length:]:
        found = getattr(found, part, None)
    if not callable(found):
        raise EvaluationError(f"there is no Python function `{path}`", span)
    if inspect.iscoroutinefunction(found):
        raise EvaluationError(f"`{path}` is asynchronous, and methods take no time", span)
    return found  # type: ignore[no-any-return]
