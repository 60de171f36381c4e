"""Actions: how Python functions say which action they carry out, and how they are bound to declarations.

A function is matched to the declaration in the `.osc` library by the names and types of its parameters when the
scenario is loaded; what does not match is an error then, not in the middle of a run.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Mapping
from types import UnionType
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypedDict, Unpack, cast, overload

from seoro.lang import frozen
from seoro.runtime.fitting import Converter, Fitting
from seoro.runtime.signatures import Declaration, check_marked, check_marking, match_function
from seoro.runtime.threads import run_in_thread
from seoro.runtime.values import Actor, Value

if TYPE_CHECKING:
    from seoro.runtime.context import ActionContext

AsyncFunction: TypeAlias = Callable[..., Coroutine[Any, Any, None]]
PlainFunction: TypeAlias = Callable[..., object]
ActionFunction: TypeAlias = AsyncFunction | PlainFunction
Part: TypeAlias = str | Callable[[Mapping[str, Value]], str]  # of an actor, or what says it, given the parameters

ACTION_MARK = "__seoro_action__"


class Mark(frozen.Value):
    """What `@action` says of a function."""

    name: str
    home: type[Any] | UnionType | None = None
    anywhere: type[Any] | UnionType | None = None
    open_ended: bool = False
    uses: Part | None = None
    thread: bool = False
    files: tuple[str, ...] = ()
    uris: tuple[str, ...] = ()


class Terms(TypedDict, total=False):
    """What `@action` may say of any function."""

    home: type[Any] | UnionType | None
    anywhere: type[Any] | UnionType | None
    open_ended: bool
    uses: Part | None
    files: tuple[str, ...]
    uris: tuple[str, ...]


@overload
def action(
    name: str, *, thread: Literal[False] = False, **terms: Unpack[Terms]
) -> Callable[[AsyncFunction], AsyncFunction]: ...


@overload
def action(
    name: str, *, thread: Literal[True], **terms: Unpack[Terms]
) -> Callable[[PlainFunction], PlainFunction]: ...


def action(name: str, *, thread: bool = False, **terms: Unpack[Terms]) -> Callable[[Any], Any]:
    """Say that a function carries out an action.

    The function is `async`, takes an `ActionContext`, then for an action of an actor the actor, then the
    parameters of the declaration by their names. Returning is success, `ActionFailed` failure.

    Args:
        name: Qualified by the actor type as in the declaration: `differential_drive_robot.nav_to_pose`.
        thread: Whether it is a plain function that blocks: it is called in a thread of its own, takes a
            `ThreadContext` in place of the `ActionContext`, and everything else goes on meanwhile.
        terms: `home`: contract that the backend in which the actor lives has to serve, or a union of those of
            which it has to serve one. `anywhere`: the same for some backend of the run. `open_ended`: whether it
            has no end of its own and goes on until something ends it, such as driving at a speed; what ends it
            then, a `duration` or the primary member of `parallel`, does not find it late. `uses`: what of the
            actor it uses that is for one action at a time, such as its `base`; for an action without an actor, of
            all that there is in the run; where that depends on the parameters, a function that is given their
            values by name. `files`: parameters that name files or folders beside the scenario file,
            which go along when it is sent elsewhere. `uris`: parameters that name what a simulator loads.
    """

    check_marking("action", name)

    def mark(function: ActionFunction) -> ActionFunction:
        check_marked("action", function)
        setattr(function, ACTION_MARK, Mark(name, thread=thread, **terms))
        return function

    return mark


class BoundAction(frozen.Value):
    """A declaration with the function that carries it out."""

    declaration: Declaration
    mark: Mark
    function: ActionFunction
    converters: Mapping[str, Converter]

    def part_of(self, fields: Mapping[str, Value]) -> str | None:
        """What of its actor it uses that is for one action at a time, given the values of its parameters."""
        uses = self.mark.uses
        return uses(fields) if callable(uses) else uses

    def call(
        self, context: ActionContext, actor: Actor | None, fields: Mapping[str, Value]
    ) -> Coroutine[Any, Any, None]:
        """Carry the action out; a value that the function's own types refuse is a fault of the function.

        Args:
            context: What it sees of the run.
            actor: Who carries it out, if it belongs to an actor.
            fields: The values of its parameters, maybe among others.
        """
        converted = {name: convert(fields[name]) for name, convert in self.converters.items()}
        leading = () if not self.declaration.has_actor else (actor,)
        if self.mark.thread:
            return run_in_thread(context, lambda inside: self.function(inside, *leading, **converted))
        # It is `async`, which was checked when the scenario was loaded.
        return cast(Coroutine[Any, Any, None], self.function(context, *leading, **converted))


def bind(declaration: Declaration, mark: Mark, function: ActionFunction, fitting: Fitting) -> BoundAction:
    """Bind a declaration to a function.

    Raises:
        Misfit: It takes other parameters.
    """
    leading = {"ctx": "ThreadContext" if mark.thread else "ActionContext"}
    if declaration.has_actor:
        leading["actor"] = "Actor"
    converters = match_function(function, leading, declaration.parameters, fitting, is_async=not mark.thread)
    return BoundAction(declaration, mark, function, converters)
