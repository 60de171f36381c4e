"""Names of behaviors in traces and messages."""

from __future__ import annotations

from collections.abc import Mapping

from seoro.lang import plan

_KINDS: Mapping[type[plan.Behavior], str] = {
    plan.Serial: "serial",
    plan.Parallel: "parallel",
    plan.OneOf: "one_of",
    plan.Wait: "wait",
    plan.Emit: "emit",
    plan.CallMethod: "call",
    plan.InvokeAction: "action",
    plan.InvokeScenario: "scenario",
}


def type_of(behavior: plan.Behavior) -> str:
    """Return the kind of a behavior, as in the trace."""
    return _KINDS[type(behavior)]


def name_of(behavior: plan.Behavior) -> str:
    """Return the label of a behavior, otherwise the name that it invokes, otherwise its kind."""
    if behavior.label:
        return behavior.label
    match behavior:
        case plan.InvokeAction() | plan.InvokeScenario():
            return invoked_name(behavior)
        case _:
            return type_of(behavior)


def invoked_name(invocation: plan.InvokeAction | plan.InvokeScenario) -> str:
    """Return the invoked name as in the scenario: on its actor, not on the declaring type."""
    name = invocation.action if isinstance(invocation, plan.InvokeAction) else invocation.scenario
    if invocation.actor is None:
        return name
    actor, short = invocation.actor.span.text, name.rpartition(".")[2]
    return short if actor == short else f"{actor}.{short}"


class Location:
    """Path of a behavior as text, composed on demand: mostly it is never read.

    Args:
        outer: Location of the composition.
        behavior: The member.
        index: Its index.
    """

    __slots__ = ("_behavior", "_index", "_outer", "_text")

    def __init__(self, outer: Location | None, behavior: plan.Behavior | None, index: int) -> None:
        self._outer = outer
        self._behavior = behavior
        self._index = index
        self._text: str | None = None

    @classmethod
    def of(cls, text: str) -> Location:
        """Return a location with a given text."""
        location = cls(None, None, 0)
        location._text = text
        return location

    @property
    def text(self) -> str:
        """The path, such as `main/serial[0]/log[1]`."""
        if self._text is None:
            parts: list[str] = []
            at: Location = self
            while at._text is None:  # not recursive: behaviors may be nested deeply
                assert at._outer is not None and at._behavior is not None
                parts.append(f"{name_of(at._behavior)}[{at._index}]")
                at = at._outer
            self._text = "/".join((at._text, *reversed(parts)))
            self._outer = self._behavior = None
        return self._text
