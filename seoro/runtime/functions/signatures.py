"""Signatures of Python functions, and their comparison with declarations by names and types."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping, Sequence
from types import FunctionType, UnionType
from typing import Any, Final, TypeVar, Union, get_args, get_origin
from weakref import WeakKeyDictionary

from seoro.errors import UsageError
from seoro.lang.frozen import Value
from seoro.lang.plan import ValueType
from seoro.lang.traits import ParameterTrait
from seoro.runtime.functions.fitting import Converter, Fitting, annotation_for
from seoro.runtime.values.values import Variable

_VALUE = ParameterTrait.VALUE
_OF_VARIABLES = (ParameterTrait.VARIABLE, ParameterTrait.NUMBER)
Marked = TypeVar("Marked")
_signatures: Final[WeakKeyDictionary[FunctionType, inspect.Signature]] = WeakKeyDictionary()
BY_NAME = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)


class Declaration(Value):
    """Declaration of an action or a modifier implemented in Python.

    Args:
        has_actor: Whether it belongs to an actor.
        parameters: Types of its parameters by name.
    """

    has_actor: bool
    parameters: Mapping[str, ValueType]


class SignatureMismatch(Exception):
    """A Python function does not match a declaration; the message describes the difference.

    Args:
        message: The difference.
        expected: A matching function header; empty if unknown.
    """

    def __init__(self, message: str, expected: str = "") -> None:
        super().__init__(message)
        self.expected = expected


def marking(decorator: str, name: object, attribute: str, mark: object) -> Callable[[Marked], Marked]:
    """Return the decorator that marks a function as an implementation.

    Args:
        decorator: Name of the decorator.
        name: Name of the declaration.
        attribute: Attribute of the function for the mark.
        mark: The mark.

    Raises:
        UsageError: The name is not a `str`, as with `@seoro.action` without a name, or the decorated object is not
            a function.
    """
    if not isinstance(name, str):
        raise UsageError(
            f"invalid `name` of `@seoro.{decorator}`: expected a str, found {name!r} ({type(name).__name__})",
            help=f'write `@seoro.{decorator}("NAME")`, with the name of the declaration',
        )

    def decorate(function: Marked) -> Marked:
        if not callable(function):
            raise UsageError(f"`@seoro.{decorator}` expects a function, found {function!r}")
        setattr(function, attribute, mark)
        return function

    return decorate


def signature_of(function: Callable[..., Any]) -> inspect.Signature:
    """Return the signature of a function with evaluated annotations; each function is read once.

    Raises:
        SignatureMismatch: The signature is unreadable.
    """
    if not isinstance(function, FunctionType):
        return _read_signature(function)
    known = _signatures.get(function)
    if known is None:
        known = _signatures[function] = _read_signature(function)
    return known


def _read_signature(function: Callable[..., Any]) -> inspect.Signature:
    try:
        return inspect.signature(function, eval_str=True)
    except (TypeError, ValueError) as error:
        raise SignatureMismatch(f"cannot read its parameters: {error}") from error
    except Exception as error:  # evaluation of an annotation may raise anything
        raise SignatureMismatch(f"cannot evaluate its annotations: {type(error).__name__}: {error}") from error


def traits(function: Callable[..., Any]) -> dict[str, ParameterTrait]:
    """Return parameters whose arguments are not passed as values of the declared type, with their traits.

    Unreadable signatures have none.
    """
    try:
        parameters = signature_of(function).parameters
    except SignatureMismatch:
        return {}
    found = {name: _trait(parameter.annotation) for name, parameter in parameters.items()}
    return {name: trait for name, trait in found.items() if trait is not ParameterTrait.VALUE}


def _trait(annotation: Any) -> ParameterTrait:
    if annotation in (object, Any):
        return ParameterTrait.ANY
    if get_origin(annotation) in (Union, UnionType):  # a variable, or the declared default for none
        return next((trait for trait in map(_trait, get_args(annotation)) if trait in _OF_VARIABLES), _VALUE)
    if (get_origin(annotation) or annotation) is not Variable:
        return ParameterTrait.VALUE
    return ParameterTrait.NUMBER if get_args(annotation) == (float,) else ParameterTrait.VARIABLE


def match_function(
    function: Callable[..., Any],
    leading: Mapping[str, str],
    declared: Mapping[str, ValueType],
    fitting: Fitting,
    *,
    is_async: bool = True,
) -> Mapping[str, Converter]:
    """Match a function with a declaration; return the converters of its parameters.

    Args:
        function: The function.
        leading: Names and annotations of the parameters before those of the declaration, for messages.
        declared: Types of the declared parameters by name.
        fitting: Matches types.
        is_async: Whether the function must be `async`.

    Raises:
        SignatureMismatch: They differ.
    """
    expected = ", ".join(
        [
            *(f"{name}: {hint}" for name, hint in leading.items()),
            *(f"{name}: {annotation_for(type_)}" for name, type_ in declared.items()),
        ]
    )
    kind = "async def" if is_async else "def"
    try:
        if is_async and not inspect.iscoroutinefunction(function):
            raise SignatureMismatch("it is not an `async` function")
        return _match(function, len(leading), declared, fitting)
    except SignatureMismatch as mismatch:
        raise SignatureMismatch(str(mismatch), f"{kind} {function.__name__}({expected})") from mismatch


def _match(
    function: Callable[..., Any], leading: int, declared: Mapping[str, ValueType], fitting: Fitting
) -> Mapping[str, Converter]:
    taken = list(signature_of(function).parameters.values())
    by_name = {parameter.name: parameter for parameter in taken[leading:] if parameter.kind in BY_NAME}
    is_led = all(parameter.kind in _LEADING for parameter in taken[:leading])
    if (
        len(taken) < leading
        or not is_led
        or len(by_name) < len(taken[leading:])
        or by_name.keys() != declared.keys()
    ):
        raise SignatureMismatch(
            f"it takes ({shown(taken[leading:])}), the declaration has ({', '.join(declared)})"
        )
    converters = {}
    for name, type_ in declared.items():
        hint = by_name[name].annotation
        if hint is inspect.Parameter.empty:
            raise SignatureMismatch(f"`{name}` has no annotation")
        converter = fitting.converter(type_, hint)
        if converter is None:
            raise SignatureMismatch(
                f"the type of `{name}` does not match the declaration: expected `{annotation_for(type_)}`, "
                f"found `{type_name(hint)}`"
            )
        converters[name] = converter
    return converters


_LEADING = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)


def shown(parameters: Sequence[inspect.Parameter]) -> str:
    """Format parameters for messages, without types."""
    marks: dict[Any, str] = {inspect.Parameter.VAR_POSITIONAL: "*", inspect.Parameter.VAR_KEYWORD: "**"}
    return ", ".join(f"{marks.get(parameter.kind, '')}{parameter.name}" for parameter in parameters)


def type_name(hint: Any) -> str:
    """Format an annotation for messages, without module names."""
    text = hint.__name__ if isinstance(hint, type) and not hasattr(hint, "__args__") else str(hint)
    return re.sub(r"\b(?:\w+\.)+(?=\w)", "", text)
