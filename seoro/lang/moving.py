"""Copies trees to other places: statements of one text that stand, unchanged, in another one."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from operator import attrgetter
from typing import Any, TypeVar

from seoro.lang.ast import Node
from seoro.lang.source import SourceFile, Span

N = TypeVar("N", bound=Node)


def moved(node: N, file: SourceFile, shift: int) -> N:
    """Copy a tree into another file.

    Args:
        node: The root of the tree.
        file: The other file.
        shift: What to add to all offsets [characters].

    Raises:
        RecursionError: The tree is too deep.
    """
    return _moved(node, file, shift)  # type: ignore[no-any-return]


def _moved(value: Any, file: SourceFile, shift: int) -> Any:
    cls = type(value)
    if cls is Span:
        return Span(file, value.start + shift, value.end + shift)
    if cls is tuple:
        return tuple([_moved(item, file, shift) for item in value]) if value else value
    fields = _fields(cls)  # type: ignore[arg-type]
    if fields is None:
        return value
    *parts, span = fields(value)
    return cls(
        *[part if part is None or type(part) is str else _moved(part, file, shift) for part in parts],
        Span(file, span.start + shift, span.end + shift),
    )


@cache
def _fields(cls: type) -> Callable[[Any], tuple[Any, ...]] | None:
    """Read all fields of a node, the last of which is its place; None for what is not a node."""
    if not issubclass(cls, Node):
        return None
    names: tuple[str, ...] = cls.__match_args__
    if len(names) > 1:
        return attrgetter(*names)
    return lambda node: (node.span,)
