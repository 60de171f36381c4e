"""Copies of trees for unchanged statements of another text.

Most of a scenario is the body of its `do`, which is copied on first use: after an edit, few bodies are used.
"""

from __future__ import annotations

from collections.abc import Callable
from operator import attrgetter
from typing import Any, Final, NamedTuple, TypeVar

from seoro.lang import ast
from seoro.lang.ast import Node
from seoro.lang.source import SourceFile, Span

MAX_DEPTH: Final = 60  # levels of a copied tree, each of which takes three Python frames
N = TypeVar("N", bound=Node)


class _Later(NamedTuple):
    """The member of a `do` to be copied."""

    member: ast.DoMember
    shift: int


class MovedDo(ast.DoDirective):
    """`do <member>`; the member is copied on first use."""

    def __init__(self, later: _Later, span: Span) -> None:
        _MEMBER.__set__(self, later)
        _SPAN.__set__(self, span)

    @property  # type: ignore[misc]
    def member(self) -> ast.DoMember:
        """The behavior."""
        found = _MEMBER.__get__(self)
        if isinstance(found, _Later):
            found = _moved(found.member, self.span.file, found.shift)
            _MEMBER.__set__(self, found)
        return found  # type: ignore[no-any-return]


_MEMBER: Final[Any] = vars(ast.DoDirective)["member"]  # the slots
_SPAN: Final[Any] = vars(ast.DoDirective)["span"]


def moved(node: N, file: SourceFile, shift: int) -> N:
    """Copy a tree into another file.

    Args:
        node: The root of a tree that is not deep.
        file: The other file.
        shift: Offset to add to all positions [characters].
    """
    return _moved(node, file, shift)  # type: ignore[no-any-return]


def is_deep(root: Node) -> bool:
    """Return whether a tree has too many levels to be copied."""
    pending: list[tuple[Any, int]] = [(root, 0)]
    while pending:
        value, depth = pending.pop()
        if depth > MAX_DEPTH:
            return True
        if isinstance(value, tuple):
            pending += [(item, depth + 1) for item in value]
        elif (fields := _GETTERS.get(type(value))) is not None:
            pending += [(field, depth + 1) for field in fields(value)]
    return False


def _moved(value: Any, file: SourceFile, shift: int) -> Any:
    cls = type(value)
    if cls is Span:
        return Span(file, value.start + shift, value.end + shift)
    if cls is tuple:
        return tuple([_moved(item, file, shift) for item in value]) if value else value
    fields = _GETTERS.get(cls)
    if fields is None:
        return value
    if isinstance(value, ast.DoDirective):
        return _moved_do(value, file, shift)
    *parts, span = fields(value)
    return cls(
        *[part if part is None or type(part) is str else _moved(part, file, shift) for part in parts],
        Span(file, span.start + shift, span.end + shift),
    )


def _moved_do(directive: ast.DoDirective, file: SourceFile, shift: int) -> MovedDo:
    member = _MEMBER.__get__(directive)
    later = _Later(member.member, member.shift + shift) if isinstance(member, _Later) else _Later(member, shift)
    return MovedDo(later, Span(file, directive.span.start + shift, directive.span.end + shift))


def _getter(cls: type[Node]) -> Callable[[Any], tuple[Any, ...]]:
    """Create a function that reads all fields of a node, the last of which is its span."""
    names: tuple[str, ...] = cls.__match_args__
    return attrgetter(*names) if len(names) > 1 else lambda node: (node.span,)


_GETTERS: Final = {
    cls: _getter(cls) for cls in (*vars(ast).values(), MovedDo) if isinstance(cls, type) and issubclass(cls, Node)
}
