"""Labels: which behaviors of a `do` have one, and what is invoked under them (7.2.2.4.7).

A label is visible anywhere in its scenario, before the place where it stands as well; one `do` has it once. In
front of a dot, that of an invocation stands for the instance of what is invoked, which the invocation binds it to
(7.6.2.2), in all that is evaluated while the scenario runs.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from seoro.lang import ast, plan
from seoro.lang.check.targets import Targets
from seoro.lang.frozen import Frozen
from seoro.lang.source import Span
from seoro.lang.symbols import TypeSymbol, do_directive
from seoro.lang.types import UNKNOWN, Structured, Type

if TYPE_CHECKING:
    from seoro.lang.check.expressions import Expressions


def labelled(member: ast.DoMember) -> list[tuple[ast.Name, ast.DoMember]]:
    """The behaviors with a label within a behavior, in the order of the text."""
    found: list[tuple[ast.Name, ast.DoMember]] = []
    stack = [member]
    while stack:
        current = stack.pop()
        if current.label is not None:
            found.append((current.label, current))
        if isinstance(current.body, ast.Composition):
            stack += reversed(current.body.members)
    return found


def names_of(path: ast.Expression) -> list[ast.Name]:
    """The names of a path that has nothing else; empty for any other expression."""
    found: list[ast.Name] = []
    while isinstance(path, ast.FieldAccess):
        found.append(path.name)
        path = path.base
    return [path.name, *reversed(found)] if isinstance(path, ast.NameExpression) else []


def path_of(names: Sequence[ast.Name]) -> ast.Expression:
    """The path that consists of some names."""
    path: ast.Expression = ast.NameExpression(names[0], names[0].span)
    for name in names[1:]:
        path = ast.FieldAccess(path, name, names[0].span.to(name.span))
    return path


class WrongLabel(Frozen):
    """What is no label, and the labels that it could be."""

    span: Span
    known: tuple[str, ...]


class Labels:
    """The labels of what a type does; none, if it is no scenario or action, or does nothing.

    Args:
        owner: The type.
        expressions: For the actors of invocations.
    """

    def __init__(self, owner: TypeSymbol, expressions: Expressions) -> None:
        self._expressions = expressions
        self._directive = do_directive(owner)
        self._inside: dict[str, Mapping[str, None]] = {}
        self._invoked: dict[TypeSymbol, Labels] = {}

    @cached_property
    def _members(self) -> dict[str, ast.DoMember]:
        found: dict[str, ast.DoMember] = {}
        if self._directive is not None:
            for label, member in labelled(self._directive.directive.member):
                found.setdefault(label.text, member)
        return found

    def __iter__(self) -> Iterator[str]:
        return iter(self._members)

    def __contains__(self, label: str) -> bool:
        return label in self._members

    def inside(self, label: str) -> Mapping[str, None]:
        """The labels within the composition that has a label, in order; none, if it is no composition."""
        if label not in self._inside:
            found = [name.text for name, _ in labelled(self._members[label]) if name.text != label]
            self._inside[label] = dict.fromkeys(found)
        return self._inside[label]

    def of(self, invoked: TypeSymbol) -> Labels:
        """The labels of what is invoked under one of these."""
        return self._invoked.setdefault(invoked, Labels(invoked, self._expressions))

    def is_invocation(self, label: str) -> bool:
        """Whether a scenario or an action is invoked under a label."""
        return isinstance(self._members[label].body, ast.BehaviorInvocation)

    def invoked(self, label: str) -> TypeSymbol | None:
        """The scenario or action that is invoked under a label; None if it is wrong, which is reported."""
        body = self._members[label].body
        assert isinstance(body, ast.BehaviorInvocation) and self._directive is not None
        target = Targets(self._expressions, self._directive.owner, self._directive.home).find(body.invocation)
        return target.symbol if target is not None else None

    def type_of(self, path: plan.LabelPath) -> Type | None:
        """What a path of labels stands for in front of a dot; None if that is no invocation."""
        label, *rest = path
        if not self.is_invocation(label):
            return None
        target = self.invoked(label)
        if target is None:
            return UNKNOWN
        return Labels(target, self._expressions).type_of(tuple(rest)) if rest else Structured(target)

    def path(self, names: Sequence[ast.Name]) -> plan.LabelPath | WrongLabel | None:
        """The labels on a path: of a composition, to one within it; of an invocation, to one of what is invoked.

        None if an invocation on the way is wrong, which is reported.
        """
        first, *rest = names
        if first.text not in self or first.namespace is not None:
            return WrongLabel(first.span, tuple(self))
        if not rest:
            return (first.text,)
        if not self.is_invocation(first.text):
            inside = self.inside(first.text)
            return self.path(rest) if rest[0].text in inside else WrongLabel(rest[0].span, tuple(inside))
        target = self.invoked(first.text)
        found = self.of(target).path(rest) if target is not None else None
        return (first.text, *found) if isinstance(found, tuple) else found
