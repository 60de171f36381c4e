"""Modifiers in Python: the decorator `@modifier`, and the binding of functions to declarations.

    @modifier("retry")
    async def retry(ctx: ModifierContext, child: Child, count: int) -> Outcome:
        outcome = await child.run()
        failures = 1
        while outcome.failed and failures <= count:
            ...

The loader of a scenario matches a function with the declaration of its modifier by the names and types of its
parameters. `contracts/modifiers.py` describes its arguments.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Coroutine, Mapping
from typing import TYPE_CHECKING, Any

from seoro.lang import frozen
from seoro.runtime.functions import signatures
from seoro.runtime.functions.fitting import Converter, Fitting
from seoro.runtime.values.values import Actor, Value
from seoro.runtime.verdict import Outcome

if TYPE_CHECKING:
    from seoro.runtime.contracts.modifiers import Child, ModifierContext

ModifierFunction = Callable[..., Coroutine[Any, Any, Outcome]]

MODIFIER_MARK = "__seoro_modifier__"


class ModifierMark(frozen.Value):
    """Argument of `@modifier`."""

    name: str


def modifier(name: str) -> Callable[[ModifierFunction], ModifierFunction]:
    """Register a function as the implementation of a modifier.

    The function is `async`. It takes a `ModifierContext`, the actor (for a modifier of an actor), the modified
    `Child`, and the parameters of the declaration by name. It returns the outcome of the
    modified behavior: that of the child, or its own. Raising `ActionFailed` is a failure too.

    Args:
        name: Name of the modifier as declared, qualified by the actor type if it has one.
    """
    return signatures.marking("modifier", name, MODIFIER_MARK, ModifierMark(name))


class BoundModifier(frozen.Value):
    """A declaration with its implementation."""

    declaration: signatures.Declaration
    function: ModifierFunction
    converters: Mapping[str, Converter]

    def call(
        self, context: ModifierContext, actor: Actor | None, child: Child, fields: Mapping[str, Value]
    ) -> Coroutine[Any, Any, Outcome]:
        """Call the function. Values refused by the types of the function are a fault of the function."""
        converted = {name: convert(fields[name]) for name, convert in self.converters.items()}
        leading = (context, actor, child) if self.declaration.has_actor else (context, child)
        return self.function(*leading, **converted)


def bind_modifier(
    declaration: signatures.Declaration, function: ModifierFunction, fitting: Fitting
) -> BoundModifier:
    """Bind a declaration to a function.

    Raises:
        SignatureMismatch: The parameters or the result differ.
    """
    leading = {"ctx": "ModifierContext", "actor": "Actor", "child": "Child"}
    if not declaration.has_actor:
        del leading["actor"]
    converters = signatures.match_function(function, leading, declaration.parameters, fitting)
    returned = signatures.signature_of(function).return_annotation
    if returned is not inspect.Signature.empty and returned is not Outcome:
        raise signatures.SignatureMismatch(f"it returns `{signatures.type_name(returned)}`, not `Outcome`")
    return BoundModifier(declaration, function, converters)
