"""Traversal of the tree of a file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeVar

from seoro.lang.ast import Node

N = TypeVar("N", bound=Node)


def children(node: Node) -> Iterator[Node]:
    """Yield the children of a node, in the order of its fields."""
    names: tuple[str, ...] = type(node).__match_args__
    for name in names:
        value = getattr(node, name)
        for item in value if isinstance(value, tuple) else (value,):
            if isinstance(item, Node):
                yield item


def walk(root: Node) -> Iterator[Node]:
    """Yield a node and all its descendants, parents first; deep trees need no recursion."""
    pending = [root]
    while pending:
        node = pending.pop()
        yield node
        pending += reversed(list(children(node)))


def find(root: Node, kind: type[N]) -> Iterator[N]:
    """Yield all nodes of a kind in a tree."""
    return (node for node in walk(root) if isinstance(node, kind))
