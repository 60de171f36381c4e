"""Arguments of `cover` and `record` (7.5.5), and the forms of their values.

Values that shape an item are literals, since buckets are the same in every run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final, TypeVar

from seoro.lang import ast
from seoro.lang.check.scopes import Scope
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import behaviors, coverage
from seoro.lang.frozen import Value
from seoro.lang.source import Span

BUCKET_ARGUMENTS: Final = ("range", "every", "buckets")
ARGUMENTS: Final = (
    "name", "override", "expression", "unit", "text", *BUCKET_ARGUMENTS, "event", "items", "ignore", "illegal",
    "disable", "target",
)  # fmt: skip
UINT_LIMIT = 2**64
_Literal = TypeVar("_Literal", ast.BoolLiteral, ast.StringLiteral, ast.RangeConstructor)


class Argument(Value):
    """An argument, and the scope of its value."""

    place: Span  # of its name, or of a positional value
    value: ast.Expression
    scope: Scope


def collect(kind: str, arguments: ast.ArgumentList, scope: Scope, bag: Bag) -> dict[str, Argument]:
    """Return the arguments by name; report unknown, positional and duplicate ones."""
    found: dict[str, Argument] = {}
    is_override = any(argument.name.text == "override" for argument in arguments.named)
    for number, value in enumerate(arguments.positional):
        if number == 0 and not is_override:
            found["name"] = Argument(value.span, value, scope)
        else:
            bag.add(coverage.unnamed_argument, value.span, kind, is_override)
    for argument in arguments.named:
        name = argument.name.text
        if name not in ARGUMENTS or argument.name.namespace is not None:
            bag.add(coverage.unknown_item_argument, argument.name.span, kind, name, ARGUMENTS)
        elif name in found:
            bag.add(behaviors.duplicate_argument, argument.name.span, name, found[name].place)
        else:
            found[name] = Argument(argument.name.span, argument.value, scope)
    return found


class Literals:
    """Reads the literal values of arguments; other values are reported.

    Args:
        arguments: The arguments of an item.
        unit: Unit of the numbers; empty if the item has none.
        bag: Bag for messages.
    """

    def __init__(self, arguments: Mapping[str, Argument], unit: str, bag: Bag) -> None:
        self._arguments = arguments
        self._unit = unit
        self._bag = bag

    def flag(self, name: str) -> bool:
        """Read `true` or `false`; default `false`."""
        node = self._literal(ast.BoolLiteral, name, "a literal `true` or `false`")
        return node is not None and node.value

    def text(self, name: str) -> str:
        """Read a string; default empty."""
        node = self._literal(ast.StringLiteral, name, "a string in quotes")
        return node.value if node is not None else ""

    def count(self, name: str) -> int:
        """Read a `uint`; default 1."""
        match self._value(name):
            case None:
                return 1
            case ast.IntegerLiteral(value) if 0 <= value < UINT_LIMIT:
                return value
            case other:
                self._refuse(other, name, "a whole number that is not negative")
                return 1

    def range(self) -> tuple[float, float] | None:
        """Read the bounds of `range`, the smaller one first."""
        node = self._literal(ast.RangeConstructor, "range", "a range of numbers", "such as `[0..100]`")
        if node is None:
            return None
        bounds = [self._number(bound, "range", f"numbers{self._in_unit}") for bound in (node.low, node.high)]
        known = sorted(bound for bound in bounds if bound is not None)
        return (known[0], known[1]) if len(known) == 2 else None

    def width(self) -> float | None:
        """Read the positive number of `every`."""
        node = self._value("every")
        if node is None:
            return None
        width = self._number(node, "every", f"a number{self._in_unit}")
        if width is not None and width <= 0:
            self._refuse(node, "every", "a number greater than 0")
            return None
        return width

    def edges(self) -> tuple[float, ...] | None:
        """Read the boundaries in `buckets`, in order."""
        match self._value("buckets"):
            case None:
                return None
            case ast.ListConstructor(items) if len(items) > 1:
                return self._ascending(items)
            case other:
                self._refuse(other, "buckets", "a list of at least two numbers", "such as `[0, 2, 6.5, 10]`")
                return None

    def _ascending(self, items: tuple[ast.Expression, ...]) -> tuple[float, ...] | None:
        edges: list[float] = []
        for item, before in zip(items, (None, *items), strict=False):
            edge = self._number(item, "buckets", f"numbers{self._in_unit}", is_bounded=False)
            if edge is None:
                return None
            if before is not None and edge < edges[-1]:
                self._bag.add(coverage.descending, item.span, item.span.text, before.span.text, before.span)
                return None
            edges.append(edge)
        return tuple(edges)

    def names(self, name: str) -> tuple[ast.Name, ...]:
        """Read a list of at least two different names; empty for other values."""
        node = self._value(name)
        assert node is not None, "called only for given arguments"
        items = node.items if isinstance(node, ast.ListConstructor) else ()
        found = tuple(item.name for item in items if isinstance(item, ast.NameExpression))
        if not items or len(found) < len(items):
            self._refuse(node, name, "a list of names of items", "such as `[speed_at_end, gap_at_end]`")
            return ()
        if len({each.text for each in found}) < max(len(found), 2):
            self._refuse(node, name, "at least two items, each once")
            return ()
        return found

    # ------------------------------------------------------------ values

    @property
    def _in_unit(self) -> str:
        return f" in `{self._unit}`, written without the unit" if self._unit else ""

    def _value(self, name: str) -> ast.Expression | None:
        argument = self._arguments.get(name)
        return argument.value if argument is not None else None

    def _literal(self, kind: type[_Literal], name: str, needed: str, hint: str = "") -> _Literal | None:
        """Return the node of a value; report one of another kind."""
        node = self._value(name)
        if node is None or isinstance(node, kind):
            return node
        self._refuse(node, name, needed, hint)
        return None

    def _number(self, node: ast.Expression, name: str, needed: str, is_bounded: bool = True) -> float | None:
        """Read a literal number; infinity is valid only where a bound may be missing."""
        match node:
            case ast.IntegerLiteral(value):
                return value
            case ast.FloatLiteral(value) if not math.isnan(value) and not (is_bounded and math.isinf(value)):
                return value
            case ast.PhysicalLiteral(value, unit) if unit.text == self._unit:
                self._refuse(node, name, needed, f"write `{value}`")
            case _:
                self._refuse(node, name, needed)
        return None

    def _refuse(self, node: ast.Expression, name: str, needed: str, hint: str = "") -> None:
        self._bag.add(coverage.invalid_argument_value, node.span, name, needed, hint)
