"""Events: references `@...`, and event specifications (7.3.10)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple, TypeAlias, assert_never

from seoro.lang import ast, plan, symbols
from seoro.lang.check.convert import Typed
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.labels import names_of, path_of
from seoro.lang.check.scopes import TIME, Scope, running_scope
from seoro.lang.check.times import check_sign
from seoro.lang.diagnostics import events as messages
from seoro.lang.source import Span
from seoro.lang.types import BOOL, UNKNOWN, is_known


class Specified(NamedTuple):
    """An event specification (None if invalid), and the scope with the name of its occurrence."""

    specification: plan.EventSpecification | None
    scope: Scope


# Target of an event path; `start`, `end` and `fail` have no symbol.
Referred: TypeAlias = tuple[plan.EventReference, symbols.EventSymbol | None]
_Own: TypeAlias = tuple[plan.OwnEvent, symbols.EventSymbol | None]


class Events:
    """Resolves events and event specifications in the scope of a type, including its labels.

    Args:
        expressions: The expression checker.
        scope: The scope, which has an owner.
    """

    def __init__(self, expressions: Expressions, scope: Scope) -> None:
        self._expressions = expressions
        self._bag = expressions.bag
        self._scope = scope
        assert scope.owner is not None
        self._owner = scope.owner
        self._labels = expressions.labels.of(scope.owner)

    # ------------------------------------------------------------ specifications

    def specification(self, node: ast.EventSpecification) -> plan.EventSpecification | None:
        """Elaborate an event specification; report an invalid one and return None."""
        return self.specified(node).specification

    def specified(self, node: ast.EventSpecification) -> Specified:
        """Return the specification with the scope of its occurrence, for `on` and `sample`."""
        if not isinstance(node, ast.EventOccurrence):
            return Specified(self._condition(node, self._scope), self._scope)
        found = self._reference(node.path)
        scope = self._scope
        if node.name is not None:
            scope = self._bind(node.name, found)
        condition = self._condition(node.condition, scope) if node.condition is not None else None
        if found is None:
            return Specified(None, scope)
        name = node.name.text if node.name is not None else None
        return Specified(plan.OnEvent(found[0], name, condition, node.span), scope)

    def _bind(self, name: ast.Name, event: Referred | None) -> Scope:
        """Return the scope with a name for the occurrence, which must differ from fields (7.3.10.4)."""
        scope = self._scope
        first = self._expressions.lookup.member(scope.space, scope.fields, name)
        if first is not None or name.text in scope.bindings:
            self._bag.add(messages.occurrence_hides_field, name.span, name.text, first.span if first else None)
        occurrence: symbols.Type = UNKNOWN
        if event is not None:
            reference, symbol = event
            phase = symbols.EventSymbol(reference.span.text, self._owner, name.span, self._owner.home)
            occurrence = symbols.EventObject(symbol or phase)
        return replace(scope, bindings={**scope.bindings, name.text: occurrence})

    def _condition(self, node: ast.EventCondition, scope: Scope) -> plan.EventCondition:
        match node:
            case ast.BoolCondition(condition, span):
                return plan.Holds(self._truth(condition, scope, "the condition"), span)
            case ast.RiseExpression(condition, span):
                return plan.Rise(self._truth(condition, scope, "the condition of `rise`"), span)
            case ast.FallExpression(condition, span):
                return plan.Fall(self._truth(condition, scope, "the condition of `fall`"), span)
            case ast.ElapsedExpression(duration, span):
                return plan.Elapsed(self._duration(duration, scope), span)
            case ast.EveryExpression(period, offset, span):
                return self._every(period, offset, span, scope)
            case _:
                assert_never(node)

    def _truth(self, node: ast.Expression, scope: Scope, context: str) -> plan.Expression:
        if self._is_event(node, scope):
            self._bag.add(messages.missing_at, node.span, node.span.text)
            return plan.Literal(False, node.span)
        return self._expressions.converted(node, BOOL, scope, context)

    def _is_event(self, node: ast.Expression, scope: Scope) -> bool:
        """Return whether a condition can only be the path of an event."""
        names = names_of(node)
        if not names or names[0].text in scope.bindings:
            return False
        lookup = self._expressions.lookup
        if lookup.member(scope.space, scope.fields, names[0]) is not None:
            return False
        if len(names) == 1:
            return lookup.member(scope.space, self._owner.inventory.events, names[0]) is not None
        return names[0].text in self._labels and not self._has_field(names, scope)

    def _has_field(self, names: Sequence[ast.Name], scope: Scope) -> bool:
        """Return whether a path leads through labels to a field of an invoked behavior."""
        for length in range(len(names) - 1, 0, -1):
            path = self._labels.path(names[:length])
            type_ = self._labels.type_of(path) if isinstance(path, tuple) else None
            if isinstance(type_, symbols.Structured):
                fields = type_.symbol.inventory.fields
                return self._expressions.lookup.member(scope.space, fields, names[length]) is not None
        return False

    def _duration(self, node: ast.Expression, scope: Scope) -> plan.Expression:
        """Elaborate a duration, or a range of durations."""
        found = self._expressions.value(node, scope, TIME)
        target: symbols.Type = symbols.RangeOf(TIME) if isinstance(found.type, symbols.RangeOf) else TIME
        duration = self._expressions.converter.convert(found, target, "the duration")
        check_sign(duration, "duration", self._bag)
        return duration

    def _every(
        self, period: ast.Expression, offset: ast.Expression | None, span: Span, scope: Scope
    ) -> plan.EventCondition:
        each = self._expressions.converted(period, TIME, scope, "the period of `every`")
        check_sign(each, "period", self._bag, is_positive=True)
        first = None
        if offset is not None:
            first = self._expressions.converted(offset, TIME, scope, "the offset of `every`")
            check_sign(first, "offset", self._bag)
        return plan.Every(each, first, span)

    # ------------------------------------------------------------ references

    def own(self, name: ast.Name) -> _Own | None:
        """Find an event of the type itself; report an unknown one and return None."""
        found = self._member_of(self._owner, name)
        if found is None and not self._is_open(self._owner, name):
            known, is_label = self._known(self._owner), name.text in self._labels
            self._bag.add(messages.unknown_event, name.span, name.text, known, is_label=is_label)
        return found

    def _reference(self, path: ast.Expression) -> Referred | None:
        """Resolve an event path; report an invalid one and return None."""
        names = names_of(path)
        if len(names) > 1 and names[0].text in self._labels:
            return self._of_label(names[0], names[1:], path.span)
        match path:
            case ast.NameExpression(name):
                return self.own(name)
            case ast.FieldAccess(base, name):
                return self._of_object(base, name, path.span)
            case _:
                self._bag.add(messages.not_an_event, path.span)
                return None

    def _of_label(self, label: ast.Name, rest: Sequence[ast.Name], span: Span) -> Referred | None:
        """Find an event of a label: a phase, an event of the invoked behavior, or one of an inner label."""
        if len(rest) == 1 and rest[0].text in symbols.PHASES:
            return plan.PhaseEvent(label.text, symbols.PHASES[rest[0].text], span), None
        if self._labels.is_invocation(label.text):
            target = self._labels.invoked(label.text)
            if target is None:
                return None
            inside = running_scope(target, target.home)
            found = Events(self._expressions, replace(inside, space=self._scope.space))._of_invoked(rest)
            return found and (plan.LabelEvent(label.text, found[0], span), found[1])
        if len(rest) > 1 and rest[0].text in self._labels.inside(label.text):
            return self._of_label(rest[0], rest[1:], span)
        if not any(self._expressions.program.is_unread(name.text) for name in (label, rest[0])):
            self._bag.add(messages.unknown_phase, rest[0].span, label.text, rest[0].text)
        return None

    def _of_invoked(self, names: Sequence[ast.Name]) -> Referred | None:
        """Find an event of this type from the view of its invoker."""
        if len(names) > 1:
            return self._reference(path_of(names))
        return self._of_type(self._owner, names[0])

    def _of_object(self, base: ast.Expression, name: ast.Name, span: Span) -> Referred | None:
        """Find an event of the object that an expression denotes."""
        if isinstance(base, ast.NameExpression) and not self._expressions.is_value(base.name, self._scope):
            if not self._is_open(self._owner, base.name):
                candidates = (*self._labels, *(field.text for field in self._scope.fields.values()))
                self._bag.add(messages.unknown_label, base.span, base.name.text, candidates)
            return None
        found = self._expressions.value(base, self._scope)
        if not is_known(found.type):
            return None
        if isinstance(found.type, symbols.CompositionObject):
            return self._of_composition(found, name, span)
        if not isinstance(found.type, symbols.Structured):
            self._bag.add(messages.no_events, base.span, self._expressions.converter.describe(found.type))
            return None
        event = self._of_type(found.type.symbol, name)
        if event is None or isinstance(found.expression, plan.Self):
            return event
        reference, symbol = event
        return plan.MemberEvent(found.expression, reference, span), symbol

    def _of_composition(self, base: Typed, name: ast.Name, span: Span) -> Referred | None:
        """Find a predefined event of a composition, or of a modified behavior."""
        if name.namespace is None and name.text in symbols.PHASES:
            phase = plan.PhaseEvent(None, symbols.PHASES[name.text], name.span)
            return plan.MemberEvent(base.expression, phase, span), None
        owner = self._expressions.converter.describe(base.type).strip("`")
        self._bag.add(messages.unknown_event, name.span, name.text, tuple(symbols.PHASES), owner)
        return None

    def _is_open(self, symbol: symbols.TypeSymbol, name: ast.Name) -> bool:
        """Return whether a type may have an unknown event or field of this name."""
        return symbols.is_open(symbol) or self._expressions.program.is_unread(name.text)

    def _of_type(self, symbol: symbols.TypeSymbol, name: ast.Name) -> _Own | None:
        """Find an event of values of a type; report an unknown one and return None."""
        found = self._member_of(symbol, name)
        if found is None and not self._is_open(symbol, name):
            owner, is_phase = symbol.qualified_name, name.text in symbols.PHASES
            self._bag.add(messages.unknown_event, name.span, name.text, self._known(symbol), owner, is_phase)
        return found

    def _member_of(self, symbol: symbols.TypeSymbol, name: ast.Name) -> _Own | None:
        event = self._expressions.lookup.member(self._scope.space, symbol.inventory.events, name)
        if event is not None:
            return plan.DeclaredEvent(event.name, name.span), event
        if name.text in symbols.PHASES and symbols.has_phases(symbol):
            return plan.PhaseEvent(None, symbols.PHASES[name.text], name.span), None
        return None

    @staticmethod
    def _known(symbol: symbols.TypeSymbol) -> tuple[str, ...]:
        declared = (event.text for event in symbol.inventory.events.values())
        return (*declared, *(symbols.PHASES if symbols.has_phases(symbol) else ()))
