"""What methods are implemented by: expressions, Python functions, or nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

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
        positional: What it is given first.
        named: What it is given by name, some of it in the place of parameters.
        parameters: The method's own parameters, which it is given too, with their types.
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
        name: What people call it.
        parameters: Their names, with the defaults of those that have one, in the scope of the method.
        result: The type of its result; None if it has none.
        body: What it does; parameters are bindings in it.
    """

    name: str
    parameters: tuple[tuple[str, Expression | None], ...]
    result: ValueType | None
    body: Expression | External | Undefined
    span: Span


ExternalFunction: TypeAlias = Callable[[Any, Sequence[Any], Mapping[str, Any]], Any]
"""What carries an external method out: given the run, the values of the positional arguments, and all others by
their names, it returns the value of the method's result."""


@dataclass(eq=False, slots=True)
class Methods:
    """The implementations of all methods, by the type that has them and the method's name.

    Calls refer to it instead of holding what they call, since methods call each other. Types are known by
    their names here, scenarios and actions by `behavior_type`. External methods are given their Python functions
    when a scenario is loaded.
    """

    _found: dict[tuple[str, str], Method] = field(default_factory=dict, repr=False)
    _functions: dict[Span, ExternalFunction] = field(default_factory=dict, repr=False)

    def add(self, type_name: str, method: str, implementation: Method) -> None:
        """Give a type an implementation; for checking."""
        self._found[type_name, method] = implementation

    def find(self, types: Iterable[str], method: str) -> Method | None:
        """The implementation that a value has whose types these are, nearest first."""
        return next((found for name in types if (found := self._found.get((name, method))) is not None), None)

    def named(self, method: str) -> Iterator[Method]:
        """All implementations of a method, whatever type has them."""
        return (found for (_, name), found in self._found.items() if name == method)

    def externals(self) -> Iterator[tuple[Method, External]]:
        """All external methods."""
        for method in self._found.values():
            if isinstance(method.body, External):
                yield method, method.body

    def bind(self, external: External, function: ExternalFunction) -> None:
        """Give an external method its Python function; for loading."""
        self._functions[external.span] = function

    def function(self, external: External) -> ExternalFunction | None:
        """The Python function of an external method; None if it was not given one."""
        return self._functions.get(external.span)


def behavior_type(name: str) -> str:
    """What `Methods` calls a scenario or an action, whose names are apart from those of types."""
    return f"{name}()"


def modifier_type(name: str) -> str:
    """What `Methods` calls a modifier, whose names are apart from those of scenarios and actions."""
    return f"modifier {name}"
