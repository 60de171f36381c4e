"""Implementations of methods: expressions, Python functions, or none."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from typing import Any, TypeAlias

from seoro.deferred import dataclass
from seoro.lang.frozen import Value
from seoro.lang.plan.expressions import Expression
from seoro.lang.plan.types import ValueType
from seoro.lang.source import Span


class Argument(Value):
    """A value for a Python function, with its type."""

    value: Expression
    type: ValueType


class External(Value):
    """A Python function that implements a method.

    Args:
        path: Its dotted path.
        positional: Its positional arguments.
        named: Its named arguments, some of which replace parameters.
        parameters: The method's own parameters, which are also passed, with their types.
    """

    path: str
    positional: tuple[Argument, ...]
    named: tuple[tuple[str, Argument], ...]
    parameters: tuple[tuple[str, ValueType], ...]
    span: Span


class Undefined(Value):
    """No implementation (7.3.7.1)."""

    span: Span


class Method(Value):
    """An implementation of a method.

    Args:
        name: Its name for people.
        parameters: Its parameters with their defaults, in the scope of the method.
        result: The type of its result, or None.
        body: Its body; parameters are bindings in it.
    """

    name: str
    parameters: tuple[tuple[str, Expression | None], ...]
    result: ValueType | None
    body: Expression | External | Undefined
    span: Span


ExternalFunction: TypeAlias = Callable[[Any, Sequence[Any], Mapping[str, Any]], Any]
"""Function of an external method: takes the run, positional and named arguments, and returns the result."""


@dataclass(eq=False)
class Methods:
    """Implementations of all methods, by type and name of the method.

    Calls refer to methods by name, since methods call each other. Types are identified by their names, scenarios
    and actions by `behavior_type`. Loading a scenario binds external methods to their Python functions.
    """

    _found: dict[tuple[str, str], Method] = field(default_factory=dict, repr=False)
    _functions: dict[Span, ExternalFunction] = field(default_factory=dict, repr=False)

    def add(self, type_name: str, method: str, implementation: Method) -> None:
        """Add an implementation of a type; for the checker."""
        self._found[type_name, method] = implementation

    def find(self, types: Iterable[str], method: str) -> Method | None:
        """Find the implementation for a value with these types, nearest first."""
        return next((found for name in types if (found := self._found.get((name, method))) is not None), None)

    def named(self, method: str) -> Iterator[Method]:
        """Yield all implementations of a method, of any type."""
        return (found for (_, name), found in self._found.items() if name == method)

    def items(self) -> Iterator[tuple[tuple[str, str], Method]]:
        """Return all implementations, by type and name of the method."""
        return iter(self._found.items())

    def externals(self) -> Iterator[tuple[Method, External]]:
        """Yield all external methods."""
        for method in self._found.values():
            if isinstance(method.body, External):
                yield method, method.body

    def bind(self, external: External, function: ExternalFunction) -> None:
        """Bind an external method to its Python function."""
        self._functions[external.span] = function

    def function(self, external: External) -> ExternalFunction | None:
        """Return the Python function of an external method; None if it is not bound."""
        return self._functions.get(external.span)


def behavior_type(name: str) -> str:
    """Return the key of a scenario or an action in `Methods`, which differs from those of types."""
    return f"{name}()"


def modifier_type(name: str) -> str:
    """Return the key of a modifier in `Methods`, which differs from those of scenarios and actions."""
    return f"modifier {name}"
