"""Labels of the behaviors of a `do`, and their invocations (7.2.2.4.7).

A label is unique in its `do`, and visible in the whole scenario, also before its place. Before a dot, the label of
an invocation denotes the invoked instance (7.6.2.2), in expressions that are evaluated while the scenario runs. So
the receiver before a dot is a value, or a label that denotes its last invocation.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

from seoro.lang import ast, plan
from seoro.lang.check.convert import Typed, nothing
from seoro.lang.check.expression_checker import ExpressionChecker
from seoro.lang.check.scopes import DURATION, Scope, duration_of
from seoro.lang.check.targets import Targets
from seoro.lang.frozen import Frozen
from seoro.lang.source import Span
from seoro.lang.symbols import FieldSymbol, Structured, Type, TypeSymbol
from seoro.lang.types import UNKNOWN


def labelled(member: ast.DoMember) -> list[tuple[ast.Name, ast.DoMember]]:
    """Return the labelled behaviors within a behavior, in source order."""
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
    """Return the names of a path; empty for any other expression."""
    found: list[ast.Name] = []
    while isinstance(path, ast.FieldAccess):
        found.append(path.name)
        path = path.base
    return [path.name, *reversed(found)] if isinstance(path, ast.NameExpression) else []


def path_of(names: Sequence[ast.Name]) -> ast.Expression:
    """Build the path of names."""
    path: ast.Expression = ast.NameExpression(names[0], names[0].span)
    for name in names[1:]:
        path = ast.FieldAccess(path, name, names[0].span.to(name.span))
    return path


class WrongLabel(Frozen):
    """An unknown label, with the known ones."""

    span: Span
    known: tuple[str, ...]


class Labels:
    """Labels of a scenario or action; empty for other types.

    Args:
        owner: The type.
        expressions: The expression checker.
        others: The labels of invoked behaviors.
    """

    def __init__(self, owner: TypeSymbol, expressions: ExpressionChecker, others: AllLabels) -> None:
        self._expressions = expressions
        self._others = others
        self._directive = owner.do
        self._inside: dict[str, Mapping[str, None]] = {}

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
        """Return the labels within a labelled composition, in order; empty for other behaviors."""
        if label not in self._inside:
            found = [name.text for name, _ in labelled(self._members[label]) if name.text != label]
            self._inside[label] = dict.fromkeys(found)
        return self._inside[label]

    def is_invocation(self, label: str) -> bool:
        """Return whether a label belongs to an invocation."""
        return isinstance(self._members[label].body, ast.BehaviorInvocation)

    def invoked(self, label: str) -> TypeSymbol | None:
        """Return the scenario or action that a label invokes; None if it is invalid, which is reported."""
        body = self._members[label].body
        assert isinstance(body, ast.BehaviorInvocation) and self._directive is not None
        target = Targets(self._expressions, self._directive.owner, self._directive.home).find(body.invocation)
        return target.symbol if target is not None else None

    def type_of(self, path: plan.LabelPath) -> Type | None:
        """Return the type of a path of labels before a dot; None if it is not an invocation."""
        label, *rest = path
        if not self.is_invocation(label):
            return None
        target = self.invoked(label)
        if target is None:
            return UNKNOWN
        return self._others.of(target).type_of(tuple(rest)) if rest else Structured(target)

    def path(self, names: Sequence[ast.Name]) -> plan.LabelPath | WrongLabel | None:
        """Resolve a path of labels, into compositions and invoked behaviors.

        Returns None if an invocation on the path is invalid, which is reported.
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
        found = self._others.of(target).path(rest) if target is not None else None
        return (first.text, *found) if isinstance(found, tuple) else found


class AllLabels:
    """The labels of all types.

    Args:
        expressions: The expression checker.
    """

    def __init__(self, expressions: ExpressionChecker) -> None:
        self._expressions = expressions
        self._known: dict[TypeSymbol, Labels] = {}

    def of(self, owner: TypeSymbol) -> Labels:
        """Return the labels of a type."""
        if owner not in self._known:
            self._known[owner] = Labels(owner, self._expressions, self)
        return self._known[owner]

    def receiver(self, node: ast.Expression, scope: Scope) -> Typed:
        """Elaborate the receiver of a field or method access."""
        if not scope.is_running or scope.owner is None:
            return self._expressions.value(node, scope)
        names, labels = names_of(node), self.of(scope.owner)
        if not names or self._expressions.is_value(names[0], scope):
            return self._expressions.value(node, scope)
        path = labels.path(names)
        if path is None:
            return nothing(node.span)
        type_ = None if isinstance(path, WrongLabel) else labels.type_of(path)
        if isinstance(path, WrongLabel) or type_ is None:
            return self._expressions.value(node, scope)
        return Typed(plan.Labelled(path, node.span), type_)


def implicit_duration(holder: Typed, name: ast.Name) -> FieldSymbol | None:
    """Return the implicit `duration` of an invocation that `it` denotes (7.6.2.4.1)."""
    is_it = isinstance(holder.expression, plan.Binding) and holder.expression.name == "it"
    if not is_it or not isinstance(holder.type, Structured) or name.namespace is not None or name.text != DURATION:
        return None
    return duration_of(holder.type.symbol)
