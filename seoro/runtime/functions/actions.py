"""Actions in Python: the decorator `@action`, and the binding of functions to declarations.

The loader of a scenario matches a function with its declaration in the `.osc` library by the names and types
of its parameters. A mismatch is an error at that time, not during a run.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Mapping
from dataclasses import field
from types import UnionType
from typing import Any, Literal, TypeAlias, TypedDict, Unpack, overload

from seoro.lang import frozen
from seoro.runtime.functions.fitting import Converter, Fitting
from seoro.runtime.functions.signatures import Declaration, marking, match_function
from seoro.runtime.values.values import Value

AsyncFunction: TypeAlias = Callable[..., Coroutine[Any, Any, None]]
PlainFunction: TypeAlias = Callable[..., object]
ActionFunction: TypeAlias = AsyncFunction | PlainFunction
Part: TypeAlias = str | Callable[[Mapping[str, Value]], str]  # a part of an actor, or a function of the parameters

RosText: TypeAlias = Literal["msg", "srv", "action", "name"]

ACTION_MARK = "__seoro_action__"


class Mark(frozen.Value):
    """Arguments of `@action`."""

    name: str
    home: type[Any] | UnionType | None = None
    anywhere: type[Any] | UnionType | None = None
    open_ended: bool = False
    uses: Part | None = None
    thread: bool = False
    files: tuple[str, ...] = ()
    uris: tuple[str, ...] = ()
    ros: Mapping[str, RosText] = field(default_factory=dict)


class ActionOptions(TypedDict, total=False):
    """Keyword arguments of `@action` for any function."""

    home: type[Any] | UnionType | None
    anywhere: type[Any] | UnionType | None
    open_ended: bool
    uses: Part | None
    files: tuple[str, ...]
    uris: tuple[str, ...]
    ros: Mapping[str, RosText]


@overload
def action(
    name: str, *, thread: Literal[False] = False, **options: Unpack[ActionOptions]
) -> Callable[[AsyncFunction], AsyncFunction]: ...


@overload
def action(
    name: str, *, thread: Literal[True], **options: Unpack[ActionOptions]
) -> Callable[[PlainFunction], PlainFunction]: ...


def action(name: str, *, thread: bool = False, **options: Unpack[ActionOptions]) -> Callable[[Any], Any]:
    """Register a function as the implementation of an action.

    The function is `async` and takes an `ActionContext`, then the actor (for an action of an actor), then the
    parameters of the declaration by name. Returning is success, `ActionFailed` failure.

    Args:
        name: Name of the action, qualified by the actor type: `differential_drive_robot.nav_to_pose`.
        thread: Whether the function blocks. It is then a plain function, called in a thread of its own with a
            `ThreadContext` instead of the `ActionContext`.
        options: `home`: contract that the backend of the actor must support; of a union, one part is enough.
            `anywhere`: the same for some backend of the run. `open_ended`: whether the action has no end of its
            own, such as driving at a speed; a `duration` or the primary member of `parallel` then ends it without
            failure. `uses`: part of the actor that only one action at a time may use, such as its `base`; without
            an actor, a part of the run. A function may return the part for the values of the parameters.
            `files`: parameters that name files or folders beside the scenario file, to be sent along to executors.
            `uris`: parameters that name resources loaded by a simulator. `ros`: parameters with a type of a topic
            (`msg`), service (`srv`) or action (`action`) of ROS, or with a `name`, whose literals are checked.
    """
    return marking("action", name, ACTION_MARK, Mark(name, thread=thread, **options))


class BoundAction(frozen.Value):
    """A declaration with its implementation."""

    declaration: Declaration
    mark: Mark
    function: ActionFunction
    converters: Mapping[str, Converter]

    def part_of(self, fields: Mapping[str, Value]) -> str | None:
        """Return the exclusively used part of the actor for the values of the parameters, or None."""
        uses = self.mark.uses
        return uses(fields) if callable(uses) else uses


def bind(declaration: Declaration, mark: Mark, function: ActionFunction, fitting: Fitting) -> BoundAction:
    """Bind a declaration to a function.

    Raises:
        SignatureMismatch: The parameters differ.
    """
    leading = {"ctx": "ThreadContext" if mark.thread else "ActionContext"}
    if declaration.has_actor:
        leading["actor"] = "Actor"
    converters = match_function(function, leading, declaration.parameters, fitting, is_async=not mark.thread)
    return BoundAction(declaration, mark, function, converters)
