"""Walks over the tree of a file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeVar

from seoro.lang.ast import Node

N = TypeVar("N", bound=Node)


def children(node: Node) -> Iterator[Node]:
    """The nodes right below a node, in the order of its fields."""
    names: tuple[str, ...] = type(node).__match_args__
    for name in names:
        value = getattr(node, name)
        for item in value if isinstance(value, tuple) else (value,):
            if isinstance(item, Node):
                yield item


def walk(root: Node) -> Iterator[Node]:
    """A node and all below it, parents first; trees may be deep, so this is no recursion."""
    pending = [root]
    while pending:
        node = pending.pop()
        yield node
        pending += reversed(list(children(node)))


def find(root: Node, kind: type[N]) -> Iterator[N]:
    """All nodes of a kind below a node, and the node itself."""
    return (node for node in walk(root) if isinstance(node, kind))
