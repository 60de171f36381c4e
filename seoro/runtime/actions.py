"""Actions: how Python functions say which action they carry out, and how they are bound to declarations.

A function is matched to the declaration in the `.osc` library by the names and types of its parameters when the
scenario is loaded; what does not match is an error then, not in the middle of a run.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Mapping
from dataclasses import dataclass
from typing import Any

from seoro.runtime.fitting import Converter, Fitting
from seoro.runtime.signatures import Declaration, match_coroutine
from seoro.runtime.values import Actor, Value

ActionFunction = Callable[..., Coroutine[Any, Any, None]]

ACTION_MARK = "__seoro_action__"


@dataclass(frozen=True)
class Mark:
    """What `@action` says of a function."""

    name: str
    home: type[Any] | None
    anywhere: type[Any] | None
    open_ended: bool


def action(
    name: str, *, home: type[Any] | None = None, anywhere: type[Any] | None = None, open_ended: bool = False
) -> Callable[[ActionFunction], ActionFunction]:
    """Say that a function carries out an action.

    The function is `async`, takes an `ActionContext`, then for an action of an actor the actor, then the
    parameters of the declaration by their names. Returning is success, `ActionFailed` failure.

    Args:
        name: Qualified by the actor type as in the declaration: `differential_drive_robot.nav_to_pose`.
        home: Contract that the backend in which the actor lives has to serve.
        anywhere: Contract that some backend of the run has to serve.
        open_ended: Whether it has no end of its own and goes on until something ends it, such as driving at a
            speed; what ends it then, a `duration` or the primary member of `parallel`, does not find it late.
    """

    def mark(function: ActionFunction) -> ActionFunction:
        setattr(function, ACTION_MARK, Mark(name, home, anywhere, open_ended))
        return function

    return mark


@dataclass(frozen=True)
class BoundAction:
    """A declaration with the function that carries it out."""

    declaration: Declaration
    mark: Mark
    function: ActionFunction
    converters: Mapping[str, Converter]

    async def call(self, context: Any, actor: Actor | None, arguments: Mapping[str, Value]) -> None:
        """Carry the action out; a value that the function's own types refuse is a fault of the function."""
        converted = {name: self.converters[name](value) for name, value in arguments.items()}
        leading = (context,) if not self.declaration.has_actor else (context, actor)
        await self.function(*leading, **converted)


def bind(declaration: Declaration, mark: Mark, function: ActionFunction, fitting: Fitting) -> BoundAction:
    """Bind a declaration to a function.

    Raises:
        Misfit: It takes other parameters.
    """
    leading = {"ctx": "ActionContext"}
    if declaration.has_actor:
        leading["actor"] = "Actor"
    converters = match_coroutine(function, leading, declaration.parameters, fitting)
    return BoundAction(declaration, mark, function, converters)
