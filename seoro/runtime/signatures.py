"""Reading the signatures of Python functions, and comparing them with declarations by names and types."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping, Sequence
from types import UnionType
from typing import Any, Union, get_args, get_origin

from seoro.errors import InvalidUse
from seoro.lang.frozen import Value
from seoro.lang.plan import ValueType
from seoro.lang.traits import ParameterTrait
from seoro.runtime.fitting import Converter, Fitting, annotation_for
from seoro.runtime.values import Variable

_VALUE = ParameterTrait.VALUE
_OF_VARIABLES = (ParameterTrait.VARIABLE, ParameterTrait.NUMBER)
BY_NAME = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)


class Declaration(Value):
    """What is declared of an action or a modifier that Python carries out.

    Args:
        has_actor: Whether it belongs to an actor.
        parameters: The types of its parameters, by their names.
    """

    has_actor: bool
    parameters: Mapping[str, ValueType]


class Misfit(Exception):
    """A Python function does not fit a declaration; the message says why.

    Args:
        message: What does not fit.
        expected: The function as it would fit; empty if that cannot be said.
    """

    def __init__(self, message: str, expected: str = "") -> None:
        super().__init__(message)
        self.expected = expected


def check_marking(decorator: str, name: object) -> None:
    """Check the name that a decorator is given.

    Raises:
        InvalidUse: It is not a `str`, as with `@seoro.action` without a name.
    """
    if not isinstance(name, str):
        raise InvalidUse(
            f"invalid `name` of `@seoro.{decorator}`: expected a str, found {name!r} ({type(name).__name__})",
            help=f'write `@seoro.{decorator}("NAME")`, with the name of the declaration',
        )


def check_marked(decorator: str, function: object) -> None:
    """Check what a decorator is applied to.

    Raises:
        InvalidUse: It is not a function.
    """
    if not callable(function):
        raise InvalidUse(f"`@seoro.{decorator}` expects a function, found {function!r}")


def signature_of(function: Callable[..., Any]) -> inspect.Signature:
    """The signature of a function, with its annotations evaluated.

    Raises:
        Misfit: It has none that can be read.
    """
    try:
        return inspect.signature(function, eval_str=True)
    except (TypeError, ValueError) as error:
        raise Misfit(f"its parameters cannot be read: {error}") from error
    except Exception as error:  # whatever the text of an annotation raises
        raise Misfit(f"its annotations cannot be evaluated: {type(error).__name__}: {error}") from error


def traits(function: Callable[..., Any]) -> dict[str, ParameterTrait]:
    """How arguments for parameters are checked and passed, other than as values of the declared type.

    Nothing is said of a signature that cannot be read.
    """
    try:
        parameters = signature_of(function).parameters
    except Misfit:
        return {}
    found = {name: _trait(parameter.annotation) for name, parameter in parameters.items()}
    return {name: trait for name, trait in found.items() if trait is not ParameterTrait.VALUE}


def _trait(annotation: Any) -> ParameterTrait:
    if annotation in (object, Any):
        return ParameterTrait.ANY
    if get_origin(annotation) in (Union, UnionType):  # a variable, or what is declared in the place of none
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
    """Match a function with the parameters of a declaration; returns how their values become its own.

    Args:
        function: The function.
        leading: What it takes before the parameters: names, for messages, and annotations.
        declared: Types of the parameters by their names, by which it takes them.
        fitting: For their types.
        is_async: Whether it has to be `async`, and not a plain function.

    Raises:
        Misfit: They do not match.
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
            raise Misfit("it is no `async` function")
        return _match(function, len(leading), declared, fitting)
    except Misfit as misfit:
        raise Misfit(str(misfit), f"{kind} {function.__name__}({expected})") from misfit


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
        raise Misfit(f"it takes ({shown(taken[leading:])}), the declaration has ({', '.join(declared)})")
    converters = {}
    for name, type_ in declared.items():
        hint = by_name[name].annotation
        if hint is inspect.Parameter.empty:
            raise Misfit(f"`{name}` has no annotation")
        converter = fitting.converter(type_, hint)
        if converter is None:
            raise Misfit(
                f"the type of `{name}` does not fit the declaration: it is `{type_name(hint)}`, "
                f"not `{annotation_for(type_)}`"
            )
        converters[name] = converter
    return converters


_LEADING = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)


def shown(parameters: Sequence[inspect.Parameter]) -> str:
    """Parameters for messages, without their types."""
    marks: dict[Any, str] = {inspect.Parameter.VAR_POSITIONAL: "*", inspect.Parameter.VAR_KEYWORD: "**"}
    return ", ".join(f"{marks.get(parameter.kind, '')}{parameter.name}" for parameter in parameters)


def type_name(hint: Any) -> str:
    """An annotation for messages, without the names of modules."""
    text = hint.__name__ if isinstance(hint, type) and not hasattr(hint, "__args__") else str(hint)
    return re.sub(r"\b(?:\w+\.)+(?=\w)", "", text)
