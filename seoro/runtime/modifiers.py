"""Modifiers in Python: how functions say which modifier they carry out, and what they have to look like.

    @modifier("retry")
    async def retry(ctx: ModifierContext, child: Child, count: int) -> Outcome:
        outcome = await child.run()
        failures = 1
        while outcome.failed and failures <= count:
            ...

A function is matched to the declaration of the modifier, by the names and types of its parameters, when the
scenario is loaded. What it gets is in `contracts.py`.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Coroutine, Mapping
from typing import Any

from seoro.lang import frozen
from seoro.runtime.contracts import Child, ModifierContext
from seoro.runtime.fitting import Converter, Fitting
from seoro.runtime.signatures import (
    Declaration,
    Misfit,
    check_marked,
    check_marking,
    match_function,
    signature_of,
    type_name,
)
from seoro.runtime.values import Actor, Value
from seoro.runtime.verdict import Outcome

ModifierFunction = Callable[..., Coroutine[Any, Any, Outcome]]

MODIFIER_MARK = "__seoro_modifier__"


class ModifierMark(frozen.Value):
    """What `@modifier` says of a function."""

    name: str


def modifier(name: str) -> Callable[[ModifierFunction], ModifierFunction]:
    """Say that a function carries out a modifier.

    The function is `async`, takes a `ModifierContext`, then for a modifier of an actor the actor, then the `Child`
    that it is applied to, then the parameters of the declaration by their names. It returns the outcome of the
    modified behavior: that of the child, or one of its own. Raising `ActionFailed` is a failure, too.

    Args:
        name: As in the declaration, qualified by the actor type if it belongs to one.
    """

    check_marking("modifier", name)

    def mark(function: ModifierFunction) -> ModifierFunction:
        check_marked("modifier", function)
        setattr(function, MODIFIER_MARK, ModifierMark(name))
        return function

    return mark


class BoundModifier(frozen.Value):
    """A declaration with the function that carries it out."""

    declaration: Declaration
    function: ModifierFunction
    converters: Mapping[str, Converter]

    def call(
        self, context: ModifierContext, actor: Actor | None, child: Child, arguments: Mapping[str, Value]
    ) -> Coroutine[Any, Any, Outcome]:
        """Carry the modifier out; a value that the function's own types refuse is a fault of the function."""
        converted = {name: self.converters[name](value) for name, value in arguments.items()}
        leading = (context, actor, child) if self.declaration.has_actor else (context, child)
        return self.function(*leading, **converted)


def bind_modifier(declaration: Declaration, function: ModifierFunction, fitting: Fitting) -> BoundModifier:
    """Bind a declaration to a function.

    Raises:
        Misfit: It takes other parameters, or returns something else.
    """
    leading = {"ctx": "ModifierContext", "actor": "Actor", "child": "Child"}
    if not declaration.has_actor:
        del leading["actor"]
    converters = match_function(function, leading, declaration.parameters, fitting)
    returned = signature_of(function).return_annotation
    if returned is not inspect.Signature.empty and returned is not Outcome:
        raise Misfit(f"it returns `{type_name(returned)}`, not `Outcome`")
    return BoundModifier(declaration, function, converters)
