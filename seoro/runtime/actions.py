"""Actions: how Python functions say which action they carry out, and how they are bound to declarations.

A function is matched to the declaration in the `.osc` library by the names and types of its parameters when the
scenario is loaded; what does not match is an error then, not in the middle of a run.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Coroutine, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from types import ModuleType
from typing import Any, get_args, get_origin, get_type_hints

from seoro.errors import InvalidUse
from seoro.lang.plan import (
    Action,
    ActorType,
    EnumType,
    EnumValue,
    ListType,
    PhysicalType,
    PrimitiveType,
    RangeType,
    StructType,
    ValueType,
)
from seoro.runtime.values import Actor, Range, Struct, Value

ActionFunction = Callable[..., Coroutine[Any, Any, None]]

_PRIMITIVES: Mapping[str, type[Any]] = {"bool": bool, "int": int, "uint": int, "float": float, "string": str}
_MARK = "__seoro_action__"


@dataclass(frozen=True)
class Mark:
    """What `@action` says of a function."""

    name: str
    home: type[Any] | None
    anywhere: type[Any] | None


def action(
    name: str, *, home: type[Any] | None = None, anywhere: type[Any] | None = None
) -> Callable[[ActionFunction], ActionFunction]:
    """Say that a function carries out an action.

    The function is `async`, takes an `ActionContext`, then for an action of an actor the actor, then the
    parameters of the declaration by their names. Returning is success, `ActionFailed` failure.

    Args:
        name: Qualified by the actor type as in the declaration: `differential_drive_robot.nav_to_pose`.
        home: Contract that the backend in which the actor lives has to serve.
        anywhere: Contract that some backend of the run has to serve.
    """

    def mark(function: ActionFunction) -> ActionFunction:
        setattr(function, _MARK, Mark(name, home, anywhere))
        return function

    return mark


@dataclass(frozen=True)
class Implementation:
    """A marked function."""

    mark: Mark
    function: ActionFunction


def implementations(modules: Iterable[ModuleType]) -> dict[str, Implementation]:
    """The actions that modules implement, by qualified name."""
    found = {}
    for module in modules:
        for value in vars(module).values():
            mark = getattr(value, _MARK, None)
            if isinstance(mark, Mark):
                found[mark.name] = Implementation(mark, value)
    return found


def takes_anything(function: ActionFunction) -> tuple[str, ...]:
    """Names of the parameters that accept a value of any type."""
    hints = get_type_hints(function)
    return tuple(name for name in inspect.signature(function).parameters if hints.get(name) is object)


@dataclass(frozen=True)
class BoundAction:
    """A declaration with the function that carries it out."""

    action: Action
    mark: Mark
    function: ActionFunction
    converters: Mapping[str, Callable[[Value], Any]]

    def call(self, context: Any, actor: Actor | None, arguments: Mapping[str, Value]) -> Coroutine[Any, Any, None]:
        """The coroutine that carries the action out."""
        converted = {name: self.converters[name](value) for name, value in arguments.items()}
        leading = (context,) if self.action.actor is None else (context, actor)
        return self.function(*leading, **converted)


def bind(action: Action, found: Mapping[str, Implementation]) -> BoundAction:
    """Bind a declaration.

    Raises:
        InvalidUse: Nothing implements it, or what does has other parameters.
    """
    implementation = found.get(action.name)
    if implementation is None:
        raise InvalidUse(
            f"nothing carries out the action `{action.name}`",
            action.span,
            f"the library `{action.library}` declares it without an implementation" if action.library else
            "actions are carried out by Python functions of an installed library",
        )  # fmt: skip
    function = implementation.function
    if not inspect.iscoroutinefunction(function):
        raise _mismatch(action, function, "it is no `async` function")
    signature = list(inspect.signature(function).parameters)
    leading = 1 if action.actor is None else 2
    declared = list(action.structure.fields)
    if sorted(signature[leading:]) != sorted(declared):
        raise _mismatch(
            action,
            function,
            f"it takes ({', '.join(signature[leading:])}), the declaration has ({', '.join(declared)})",
        )
    hints = get_type_hints(function)
    converters = {}
    for parameter in action.structure.fields.values():
        converter = _converter(parameter.type, hints.get(parameter.name))
        if converter is None:
            raise _mismatch(action, function, f"the type of `{parameter.name}` does not fit the declaration")
        converters[parameter.name] = converter
    return BoundAction(action, implementation.mark, function, converters)


def _mismatch(action: Action, function: ActionFunction, why: str) -> InvalidUse:
    name = f"{function.__module__}.{function.__qualname__}"
    return InvalidUse(f"`{name}` cannot carry out the action `{action.name}`: {why}", action.span)


def _converter(declared: ValueType, hint: Any) -> Callable[[Value], Any] | None:
    """How a value of the declared type becomes what the function takes; None if it does not fit."""
    if hint is object:
        return _same
    match declared:
        case PrimitiveType(name):
            return _same if hint is _PRIMITIVES[name] else None
        case PhysicalType():
            return _same if hint is float else None
        case EnumType():
            return _same if hint is EnumValue else None
        case ActorType():
            return _same if hint is Actor else None
        case RangeType():
            return _same if hint is Range else None
        case StructType(fields=names):
            if hint is Struct:
                return _same
            return (
                _build(hint) if is_dataclass(hint) and {part.name for part in fields(hint)} == set(names) else None
            )
        case ListType(element):
            if get_origin(hint) not in (list, tuple, Sequence):
                return None
            item = _converter(element, get_args(hint)[0])
            return (lambda value: [item(part) for part in value]) if item else None  # type: ignore[union-attr]


def _same(value: Value) -> Any:
    return value


def _build(kind: Any) -> Callable[[Value], Any]:
    """How a struct becomes a dataclass with the same fields."""
    nested = {field.name: get_type_hints(kind)[field.name] for field in fields(kind)}

    def build(value: Value) -> Any:
        assert isinstance(value, Struct)
        return kind(**{
            name: _build(hint)(value.fields[name]) if is_dataclass(hint) else value.fields[name]
            for name, hint in nested.items()
        })  # fmt: skip

    return build
