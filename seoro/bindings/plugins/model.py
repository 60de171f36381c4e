"""Stand-ins for the objects that classes for scenario_execution receive: model, logger, clock, blackboard."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Collection, Mapping
from typing import Any

from seoro.bindings.plugins.values import passed, returned
from seoro.lang.plan import ValueType
from seoro.runtime.actions.threads import ThreadContext
from seoro.runtime.values.values import Actor, Variable


class Model:
    """Declaration of an invocation, with the values of its parameters.

    Args:
        name: Label or name of the invocation.
        actor: Its actor, if any.
        arguments: Values of the parameters.
        source: Place of the invocation in the scenario.
    """

    def __init__(self, name: str, actor: Actor | None, arguments: Mapping[str, Any], source: str) -> None:
        self.name = name
        self.actor = ActorModel(actor) if actor is not None else None
        self._arguments = arguments
        self._source = source

    def get_resolved_value(
        self, blackboard: Any = None, skip_keys: Collection[str] | None = None
    ) -> dict[str, Any]:
        """Return the values of the parameters except `skip_keys`."""
        return {name: value for name, value in self._arguments.items() if name not in (skip_keys or ())}

    def get_resolved_value_with_variable_references(
        self, blackboard: Any = None, skip_keys: Collection[str] | None = None
    ) -> dict[str, Any]:
        """Refuse to pass variables instead of their values.

        Raises:
            NotImplementedError: Always.
        """
        raise NotImplementedError(
            "references to variables are unsupported: write the action as a function with a parameter of type "
            "`seoro.Variable`"
        )

    def get_ctx(self) -> tuple[int, int, str, str]:
        """Return line, column, text and file of the invocation."""
        file, line, column = self._source.rsplit(":", 2)
        return int(line), int(column), self.name, file


class ActorModel:
    """Declaration of an actor, with the values of its fields."""

    def __init__(self, actor: Actor) -> None:
        self._actor = actor
        self.name = actor.name

    def get_resolved_value(self, blackboard: Any = None) -> dict[str, Any]:
        """Return the values of the fields, and the name."""
        fields: dict[str, Any] = passed(self._actor)
        return fields

    def get_qualified_name(self) -> str:
        """Return the name with which keys of the blackboard begin."""
        return f"/{self.name}"


class Blackboard:
    """Variables of an actor, as attributes `/ACTOR/VARIABLE`."""

    def __init__(self, ctx: ThreadContext, actor: Actor, variables: Mapping[str, ValueType]) -> None:
        vars(self)["_variables"] = {
            f"/{actor.name}/{name}": Variable(actor, name, type_, f"{actor.name}.{name}")
            for name, type_ in variables.items()
        }
        vars(self)["_ctx"] = ctx

    def register_key(self, key: str, access: Any = None) -> None:
        """Check that a variable exists.

        Raises:
            KeyError: It does not.
        """
        self._variable(key)

    def __getattr__(self, key: str) -> Any:
        return passed(self._variable(key).value)

    def __setattr__(self, key: str, value: Any) -> None:
        variable = self._variable(key)
        written = returned(value, variable.type, variable.path)
        self._ctx.update(variable, lambda _: written)

    get, set = __getattr__, __setattr__

    def _variable(self, key: str) -> Variable[Any]:
        variables: dict[str, Variable[Any]] = self._variables
        if key not in variables:
            raise KeyError(f"unknown variable `{key}` (variables: {', '.join(variables)})")
        return variables[key]


class Clock:
    """A clock with the method `now`; after the end of the action it returns its last value.

    Args:
        read: Returns the time [s].
    """

    def __init__(self, read: Callable[[], float]) -> None:
        self._read = read
        self._last = 0.0

    def now(self) -> float:
        """Return the time [s]."""
        try:
            self._last = self._read()
        except asyncio.CancelledError:
            return self._last
        return self._last


class Logger:
    """Logger with a method for each level.

    Args:
        write: Receives messages with their levels.
    """

    def __init__(self, write: Callable[[str, str], None]) -> None:
        self._write = write

    def debug(self, message: object) -> None:
        """Drop a message: trees log each tick at this level."""

    def info(self, message: object) -> None:
        """Write a message of the level `info`."""
        self._write(str(message), "info")

    def warning(self, message: object) -> None:
        """Write a message of the level `warning`."""
        self._write(str(message), "warning")

    def error(self, message: object) -> None:
        """Write a message of the level `error`."""
        self._write(str(message), "error")
